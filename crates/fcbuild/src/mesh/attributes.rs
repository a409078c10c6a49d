//! Normals and colours through welding and copying.

use super::shares::{share, shares};
use crate::import::Tally;
use crate::import::tally::{MIXED_NORMALS, differ};
use glam::{DVec3, Vec3};
use rayon::prelude::*;

/// Per welded vertex: the mean of what its input vertices said.
pub(super) struct Attributes {
    normals: Option<Vec<Vec3>>,
    colors: Option<Vec<[u8; 4]>>,
}

impl Attributes {
    /// Averages attributes over welded vertices; vertices that disagree are counted as a warning.
    pub(super) fn merge(
        representative: &[u32],
        normals: Option<Vec<[f32; 3]>>,
        colors: Option<Vec<[u8; 4]>>,
        tally: &mut Tally,
    ) -> Attributes {
        let n = representative.len();
        let mut mixed = 0;
        let normals = normals.filter(|v| v.len() == n).map(|given| {
            let mut sum = vec![Vec3::ZERO; n];
            let unit = |v: usize| {
                let normal = Vec3::from(given[v]);
                if normal.is_finite() { normal.normalize_or_zero() } else { Vec3::ZERO }
            };
            for (v, &r) in representative.iter().enumerate() {
                let normal = unit(v);
                // Where there is no normal there is none to be lost.
                if r as usize != v && normal != Vec3::ZERO && differ(normal.into(), unit(r as usize).into()) {
                    mixed += 1;
                }
                sum[r as usize] += normal;
            }
            sum.iter_mut().for_each(|s| *s = s.normalize_or_zero());
            sum
        });
        tally.warn("mixed_normals", mixed, MIXED_NORMALS);
        let mut conflicts = 0;
        let colors = colors.filter(|v| v.len() == n).map(|given| {
            let mut sum = vec![[0_u32; 5]; n];
            for (v, &r) in representative.iter().enumerate() {
                conflicts += u64::from(given[v] != given[r as usize]);
                let s = &mut sum[r as usize];
                for (channel, total) in given[v].iter().zip(s.iter_mut()) {
                    *total = total.saturating_add(u32::from(*channel));
                }
                s[4] += 1;
            }
            sum.iter()
                .map(|s| [0, 1, 2, 3].map(|c| ((s[c] + s[4] / 2) / s[4].max(1)).min(255) as u8))
                .collect()
        });
        if conflicts > 0 {
            tally.warn("FC291", conflicts, "welded vertices had different colours; their mean was taken");
        }
        Attributes { normals, colors }
    }

    /// Unit normals for every vertex and copy; where the input gives none, the area-weighted mean of the faces.
    pub(super) fn normals_or_mean(&self, positions: &[Vec3], faces: &[[u32; 3]], weld: &[u32]) -> Vec<Vec3> {
        let mut normals: Vec<Vec3> = match &self.normals {
            Some(given) => weld.iter().map(|&w| given[w as usize]).collect(),
            None => vec![Vec3::ZERO; positions.len()],
        };
        if self.normals.is_none() || normals.contains(&Vec3::ZERO) {
            normals.par_chunks_mut(share(positions.len())).zip(shares(positions.len())).for_each(
                |(normals, own)| {
                    let mut mean = vec![DVec3::ZERO; own.len()];
                    for face in faces {
                        if !face.iter().any(|v| own.contains(&(*v as usize))) {
                            continue;
                        }
                        let [a, b, c] = face.map(|v| positions[v as usize].as_dvec3());
                        let area_vector = (b - a).cross(c - a);
                        for v in face {
                            if let Some(m) =
                                (*v as usize).checked_sub(own.start).and_then(|v| mean.get_mut(v))
                            {
                                *m += area_vector;
                            }
                        }
                    }
                    for (n, m) in normals.iter_mut().zip(mean).filter(|(n, _)| **n == Vec3::ZERO) {
                        *n = m.normalize_or_zero().as_vec3();
                    }
                },
            );
        }
        normals
    }

    /// Colours for every vertex and copy.
    pub(super) fn colors_of_copies(self, weld: &[u32]) -> Option<Vec<[u8; 4]>> {
        self.colors.map(|given| weld.iter().map(|&w| given[w as usize]).collect())
    }
}
