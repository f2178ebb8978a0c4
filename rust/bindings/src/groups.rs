//! Groups of meshes and pairs of groups.

use kinmo_geometry::{GeometryError, Result};
use numpy::PyReadonlyArrayDyn;

use crate::arrays::rows_of;

/// The indices of the meshes of every group, checked; without groups, every mesh by itself.
pub fn groups_of<I>(meshes: usize, groups: Option<Vec<Vec<I>>>) -> Result<Vec<Vec<usize>>>
where
    I: Copy + TryInto<usize>,
{
    let Some(groups) = groups else { return Ok((0..meshes).map(|mesh| vec![mesh]).collect()) };
    let mut checked = Vec::with_capacity(groups.len());
    for (index, group) in groups.into_iter().enumerate() {
        // A negative index is as much out of range as one that is too large.
        let members: Vec<usize> = group.into_iter().map(|member| member.try_into().unwrap_or(usize::MAX)).collect();
        check_members(&format!("groups[{index}]"), meshes, &members)?;
        checked.push(members);
    }
    Ok(checked)
}

/// Refuses an empty list and indices out of range.
pub fn check_members(name: &str, meshes: usize, members: &[usize]) -> Result<()> {
    if members.is_empty() {
        return Err(GeometryError::new(name, "empty, expected at least one mesh"));
    }
    match members.iter().find(|&&mesh| mesh >= meshes) {
        Some(mesh) => Err(GeometryError::new(name, format!("index {mesh} is outside 0..{meshes}"))),
        None => Ok(()),
    }
}

/// Pairs [E, 2] of different groups.
pub fn pairs_of(groups: usize, pairs: &PyReadonlyArrayDyn<'_, u32>) -> Result<Vec<(usize, usize)>> {
    let rows = rows_of("pairs", pairs.as_array(), 2)?;
    let pairs: Vec<(usize, usize)> = rows.rows().into_iter().map(|row| (row[0] as usize, row[1] as usize)).collect();
    for (row, &(a, b)) in pairs.iter().enumerate() {
        if a >= groups || b >= groups {
            return Err(GeometryError::new("pairs", format!("row {row} has an index outside 0..{groups}")));
        }
        if a == b {
            return Err(GeometryError::new("pairs", format!("row {row} pairs group {a} with itself")));
        }
    }
    Ok(pairs)
}
