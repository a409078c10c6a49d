//! The polygons of a page.

use super::best::{BEST_UP_TO, Best};
use crate::criterion::Criterion;
use crate::page::Mesh;
use fct::{Branch, Page};

/// Draws clusters of one page at a time.
#[derive(Debug)]
pub(crate) struct PagePolygon {
    /// What is known of each vertex of the page, by its local index.
    state: [State; 256],
    /// Its index in the tree.
    vertex: [u32; 256],
    /// Where it is, if it is active, in steps of the page's grid.
    x: [f32; 256],
    y: [f32; 256],
    z: [f32; 256],
    /// The active vertices of the loops that were read last.
    ring: [u8; 256],
    best: Best,
}

/// What is left of a cluster's loops.
enum Rings {
    None,
    /// A single loop, of so many corners.
    One(usize),
    Several,
}

#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum State {
    Unknown,
    Inactive,
    Active,
}

impl Default for PagePolygon {
    fn default() -> Self {
        PagePolygon {
            state: [State::Unknown; 256],
            vertex: [0; 256],
            x: [0.0; 256],
            y: [0.0; 256],
            z: [0.0; 256],
            ring: [0; 256],
            best: Best::default(),
        }
    }
}

impl PagePolygon {
    /// Forgets what is known, for another page; false if that has more vertices than it may.
    pub(crate) fn begin(&mut self, page: &Page<'_>) -> bool {
        self.state = [State::Unknown; 256];
        page.vertex_count() <= self.state.len()
    }

    /// Appends the triangles of a node of two faces or more; false, and nothing, if it must be drawn the general way; none
    /// if the page does not have what it says.
    #[inline]
    pub(crate) fn draw(
        &mut self,
        page: &Page<'_>,
        branch: &Branch,
        criterion: &impl Criterion,
        mesh: &mut Mesh<'_>,
    ) -> Option<bool> {
        let (frame, bound) = page.plane(branch)?;
        mesh.stats.bound = mesh.stats.bound.max(bound);
        let corners = match self.thin(page, branch, criterion)? {
            Rings::None => return Some(true),
            Rings::One(corners) if corners <= BEST_UP_TO => corners,
            Rings::One(_) | Rings::Several => return Some(false),
        };
        // Where the cluster folds over there is no direction that all its faces face.
        let Some(frame) = frame else { return Some(false) };
        let [tangent, other, axis] = frame.axes;
        let [first, second, third, ..] = self.ring;
        // Places from the first corner on, which loses no digits of small polygons far from the origin.
        let origin = self.place(first);
        if corners == 3 {
            mesh.indices
                .extend_from_slice(&[first, second, third].map(|local| self.vertex[usize::from(local)]));
            let (u, v) = (minus(self.place(second), origin), minus(self.place(third), origin));
            let twice_area = dot(u, tangent) * dot(v, other) - dot(v, tangent) * dot(u, other);
            mesh.stats.folded += u64::from(twice_area < 0.0);
            return Some(true);
        }
        let base = page.vertex(page.first_face(branch)?[0])?.1.position();
        let base = base.map(|c| c * page.per_quantum());
        let [u, v] = frame.lean;
        let across = sum(axis, sum(times(u, tangent), times(v, other)));
        let level = dot(minus(base, origin), across) + frame.height * frame.length;
        let mut vertices = [0_u32; BEST_UP_TO];
        let Best { x, y, height, .. } = &mut self.best;
        let ring = self.ring.as_chunks::<4>().0;
        for (four, locals) in ring.iter().enumerate().take(corners.div_ceil(4)) {
            let at = 4 * four;
            for (lane, local) in locals.iter().enumerate() {
                let local = usize::from(*local);
                x[at + lane] = self.x[local];
                y[at + lane] = self.y[local];
                height[at + lane] = self.z[local];
                vertices[at + lane] = self.vertex[local];
            }
            for i in at..at + 4 {
                let d = [x[i] - origin[0], y[i] - origin[1], height[i] - origin[2]];
                x[i] = dot(d, tangent);
                y[i] = dot(d, other);
                height[i] = dot(d, across) - level;
            }
        }
        let mut indices = [0; 3 * (BEST_UP_TO - 2)];
        let mut end = 0;
        let found = self.best.show(corners, |[a, b, c]| {
            if let Some(slot) = indices[end..].first_chunk_mut() {
                *slot = [vertices[a], vertices[b], vertices[c]];
                end += 3;
            }
        });
        if found {
            mesh.indices.extend_from_slice(&indices[..end]);
        }
        Some(found)
    }

    /// Leaves the active vertices of a branch's loops in `ring`.
    #[inline]
    fn thin(&mut self, page: &Page<'_>, branch: &Branch, criterion: &impl Criterion) -> Option<Rings> {
        let (mut kept, mut several, mut sound) = (0_usize, false, true);
        page.rings(branch, |entries| {
            let start = kept;
            let mut end = start;
            for &local in entries {
                let mut state = self.state[usize::from(local)];
                if state == State::Unknown {
                    match self.look_at(page, criterion, local) {
                        Some(found) => state = found,
                        None => sound = false,
                    }
                }
                self.ring[end % 256] = local;
                end += usize::from(state == State::Active);
            }
            if end > start + 2 {
                several |= start > 0;
                kept = end;
            }
        })?;
        sound.then_some(match kept {
            0 => Rings::None,
            _ if several => Rings::Several,
            n => Rings::One(n),
        })
    }

    #[inline]
    fn place(&self, local: u8) -> [f32; 3] {
        let local = usize::from(local);
        [self.x[local], self.y[local], self.z[local]]
    }

    /// Looks a vertex up.
    fn look_at(&mut self, page: &Page<'_>, criterion: &impl Criterion, local: u8) -> Option<State> {
        let (vertex, record) = page.vertex(local)?;
        let local = usize::from(local);
        let state = if criterion.activates(vertex, record) { State::Active } else { State::Inactive };
        self.state[local] = state;
        self.vertex[local] = vertex;
        if state == State::Active {
            [self.x[local], self.y[local], self.z[local]] = record.position().map(|c| c * page.per_quantum());
        }
        Some(state)
    }
}

fn sum([ax, ay, az]: [f32; 3], [bx, by, bz]: [f32; 3]) -> [f32; 3] {
    [ax + bx, ay + by, az + bz]
}

fn times(t: f32, [x, y, z]: [f32; 3]) -> [f32; 3] {
    [t * x, t * y, t * z]
}

fn minus([ax, ay, az]: [f32; 3], [bx, by, bz]: [f32; 3]) -> [f32; 3] {
    [ax - bx, ay - by, az - bz]
}

fn dot([ax, ay, az]: [f32; 3], [bx, by, bz]: [f32; 3]) -> f32 {
    ax * bx + ay * by + az * bz
}
