//! Groups of meshes that are one part each, and work done a group at a time.

use kinmo_geometry::{GeometryError, Mesh, Result};
use nalgebra::Point3;
use numpy::PyReadonlyArrayDyn;
use pyo3::prelude::*;
use rayon::prelude::*;

use crate::arrays::rows_of;
use crate::convert::value_error;

/// Items handed to each thread before Python is asked whether Ctrl-C was pressed.
const ITEMS_PER_THREAD: usize = 4;

/// The indices of the meshes of every group, checked; without groups, every mesh by itself.
pub fn groups_of(meshes: usize, groups: Option<Vec<Vec<i64>>>) -> Result<Vec<Vec<usize>>> {
    let Some(groups) = groups else { return Ok((0..meshes).map(|mesh| vec![mesh]).collect()) };
    groups.iter().enumerate().map(|(index, group)| members_of(&format!("groups[{index}]"), meshes, group)).collect()
}

/// A checked list of indices of meshes: not empty, none out of range.
pub fn members_of(name: &str, meshes: usize, members: &[i64]) -> Result<Vec<usize>> {
    if members.is_empty() {
        return Err(GeometryError::new(name, "empty, expected at least one mesh"));
    }
    let index = |mesh: i64| usize::try_from(mesh).ok().filter(|&mesh| mesh < meshes);
    let outside = |mesh: i64| GeometryError::new(name, format!("index {mesh} is outside 0..{meshes}"));
    members.iter().map(|&mesh| index(mesh).ok_or_else(|| outside(mesh))).collect()
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

/// Indices of the meshes of every part.
pub struct Groups(Vec<Vec<usize>>);

impl Groups {
    /// Checks `groups`; without any, every one of the `mesh_count` meshes is a part by itself.
    pub fn new(groups: Option<Vec<Vec<i64>>>, mesh_count: usize) -> PyResult<Self> {
        Ok(Self(groups_of(mesh_count, groups).map_err(value_error)?))
    }

    /// What `work` makes of every group, in order.
    pub fn map<T: Send>(&self, py: Python<'_>, work: impl Fn(&[usize]) -> T + Sync) -> PyResult<Vec<T>> {
        map_in_batches(py, &self.0, |group| work(group))
    }

    /// What `work` makes of the vertices of every group.
    pub fn map_vertices<T: Send>(
        &self,
        py: Python<'_>,
        meshes: &[Mesh],
        work: impl Fn(&[Point3<f64>]) -> T + Sync,
    ) -> PyResult<Vec<T>> {
        self.map(py, |group| match group {
            [only] => work(meshes[*only].vertices()),
            _ => work(&group.iter().flat_map(|&i| meshes[i].vertices()).copied().collect::<Vec<_>>()),
        })
    }

    /// What `work` makes of the mesh of every group.
    pub fn map_meshes<T: Send>(
        &self,
        py: Python<'_>,
        meshes: &[Mesh],
        work: impl Fn(&Mesh) -> T + Sync,
    ) -> PyResult<Vec<T>> {
        self.map(py, |group| match group {
            [only] => work(&meshes[*only]),
            _ => work(&Mesh::union(group.iter().map(|&i| &meshes[i]))),
        })
    }
}

/// What `work` makes of every item, in order: in parallel, without the GIL, and looking for Ctrl-C between batches.
pub fn map_in_batches<I: Sync, T: Send>(
    py: Python<'_>,
    items: &[I],
    work: impl Fn(&I) -> T + Sync,
) -> PyResult<Vec<T>> {
    let mut results = Vec::with_capacity(items.len());
    for batch in items.chunks(ITEMS_PER_THREAD * rayon::current_num_threads()) {
        results.extend(py.detach(|| batch.par_iter().map(&work).collect::<Vec<_>>()));
        py.check_signals()?;
    }
    Ok(results)
}
