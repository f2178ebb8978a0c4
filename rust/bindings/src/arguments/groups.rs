//! Checked groups of meshes, pairs of groups, and ranges of rows.

use std::ops::Range;

use kinmo_geometry::{GeometryError, Result};

use crate::arguments::arrays::{Array, check_shape, rows_of};
use crate::arguments::numbers::Index;

/// Checked mesh indices of every group. Without groups, every mesh is a group.
pub fn groups_of(meshes: usize, groups: Option<Vec<Vec<Index>>>) -> Result<Vec<Vec<usize>>> {
    let Some(groups) = groups else { return Ok((0..meshes).map(|mesh| vec![mesh]).collect()) };
    groups.iter().enumerate().map(|(index, group)| members_of(&format!("groups[{index}]"), meshes, group)).collect()
}

/// Checked list of mesh indices: not empty, and all in range.
pub fn members_of(name: &str, meshes: usize, members: &[Index]) -> Result<Vec<usize>> {
    if members.is_empty() {
        return Err(GeometryError::new(name, "empty, expected at least one mesh"));
    }
    let index = |mesh: i64| usize::try_from(mesh).ok().filter(|&mesh| mesh < meshes);
    let outside = |mesh: i64| GeometryError::new(name, format!("index {mesh} is outside 0..{meshes}"));
    members.iter().map(|&Index(mesh)| index(mesh).ok_or_else(|| outside(mesh))).collect()
}

/// Checked pairs `[E, 2]` of different groups.
pub fn pairs_of(groups: usize, pairs: &Array<'_, u32>) -> Result<Vec<(usize, usize)>> {
    let rows = rows_of("pairs", pairs.view(), 2)?;
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

/// Checked ranges between consecutive bounds. The bounds ascend from 0 to `count`; equal neighbours are allowed.
pub fn ranges_of(name: &str, bounds: &Array<'_, i64>, count: usize) -> Result<Vec<Range<usize>>> {
    let bounds = bounds.view();
    check_shape(name, &bounds, &[bounds.len()])?;
    let bounds: Vec<i64> = bounds.iter().copied().collect();
    let ends = bounds.first() == Some(&0) && bounds.last() == i64::try_from(count).ok().as_ref();
    if !ends || bounds.windows(2).any(|two| two[0] > two[1]) {
        return Err(GeometryError::new(name, format!("expected numbers that rise from 0 to {count}")));
    }
    Ok(bounds.windows(2).map(|two| two[0] as usize..two[1] as usize).collect())
}
