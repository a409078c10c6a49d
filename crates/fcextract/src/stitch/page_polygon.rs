//! The polygons of a page.

use super::best::{BEST_UP_TO, Best};
use crate::criterion::Criterion;
use crate::eager::Table;
use crate::page::Mesh;
use fct::{Branch, Page};

/// Draws clusters of one page at a time.
#[derive(Debug)]
pub(crate) struct PagePolygon {
    /// 1 for each vertex of the page that is active, 0 for one that is not, by its local index, and [`ABSENT`] beyond.
    state: [u8; 256],
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

/// Stands for a vertex that the page does not have.
const ABSENT: u8 = 2;

/// Room for the corners of a polygon: a power of two is soon checked.
const ROOM: usize = BEST_UP_TO.next_power_of_two();

impl Default for PagePolygon {
    fn default() -> Self {
        PagePolygon {
            state: [ABSENT; 256],
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
    /// Looks the vertices of a page up that may be active, and counts those that are; none if it has more than it may,
    /// or does not have what it says.
    pub(crate) fn begin(
        &mut self,
        page: &Page<'_>,
        eager: Option<&Table>,
        criterion: &impl Criterion,
    ) -> Option<usize> {
        self.state = [ABSENT; 256];
        self.state.get_mut(..page.vertex_count())?.fill(0);
        let least = criterion.least();
        let mut active = 0;
        let is_known = eager.is_some_and(|eager| {
            eager.show_of_page(page, least, |local| {
                active += usize::from(self.look_at(page, local, criterion));
            })
        });
        if is_known { Some(active) } else { self.look_at_all(page, criterion) }
    }

    #[inline]
    fn look_at(&mut self, page: &Page<'_>, local: u8, criterion: &impl Criterion) -> bool {
        let Some((index, record)) = page.vertex(local) else { return false };
        let local = usize::from(local);
        let is_active = criterion.activates(index, record);
        if is_active {
            self.state[local] = 1;
            self.vertex[local] = index;
            [self.x[local], self.y[local], self.z[local]] = record.position().map(|c| c * page.per_quantum());
        }
        is_active
    }

    /// Looks all vertices of a page up, one after the other, without a guess that can go wrong.
    fn look_at_all(&mut self, page: &Page<'_>, criterion: &impl Criterion) -> Option<usize> {
        let (first, own) = page.own_vertices();
        let links = page.links();
        let (own_slots, other_slots) = self.vertex.split_at_mut(own.len().min(256));
        for (slot, ahead) in own_slots.iter_mut().zip(0_u32..) {
            *slot = first.wrapping_add(ahead);
        }
        for (slot, link) in other_slots.iter_mut().zip(links) {
            *slot = link.get();
        }
        let mut active = [0_u8; 256];
        let mut count = 0_usize;
        let mut note = |local: usize, is_active: bool| {
            self.state[local % 256] = u8::from(is_active);
            active[count % 256] = local as u8;
            count += usize::from(is_active);
        };
        for (local, record) in own.iter().enumerate() {
            note(local, criterion.activates(first.wrapping_add(local as u32), record));
        }
        for (local, link) in links.iter().enumerate() {
            let record = page.record_of_vertex(link.get())?;
            note(own.len() + local, criterion.activates(link.get(), record));
        }
        for &local in active.iter().take(count) {
            let local = usize::from(local);
            let record = page.record_of_vertex(self.vertex[local])?;
            [self.x[local], self.y[local], self.z[local]] = record.position().map(|c| c * page.per_quantum());
        }
        Some(count)
    }

    /// Appends the triangles of a node of two faces or more; false, and nothing, if it must be drawn the general way; none
    /// if the page does not have what it says.
    #[inline]
    pub(crate) fn draw(&mut self, page: &Page<'_>, branch: &Branch, mesh: &mut Mesh<'_>) -> Option<bool> {
        let (frame, bound) = page.plane(branch)?;
        mesh.stats.bound = mesh.stats.bound.max(bound);
        let corners = match self.thin(page, branch)? {
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
        let mut vertices = [0_u32; ROOM];
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
        Some(self.best.show(corners, |triangle| {
            mesh.indices.extend_from_slice(&triangle.map(|corner| vertices[corner % ROOM]));
        }))
    }

    /// Leaves the active vertices of a branch's loops in `ring`.
    #[inline]
    fn thin(&mut self, page: &Page<'_>, branch: &Branch) -> Option<Rings> {
        let (mut kept, mut several, mut seen) = (0_usize, false, 0);
        page.rings(branch, |entries| {
            let start = kept;
            let mut end = start;
            for &local in entries {
                let state = self.state[usize::from(local)];
                seen |= state;
                self.ring[end % 256] = local;
                end += usize::from(state & 1);
            }
            if end > start + 2 {
                several |= start > 0;
                kept = end;
            }
        })?;
        (seen & ABSENT == 0).then_some(match kept {
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
