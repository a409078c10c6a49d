//! The polygons of a page.

use super::best::{BEST_UP_TO, Best};
use crate::criterion::Criterion;
use crate::eager::{Kept, Table};
use crate::page::Mesh;
use fct::{Branch, Loops, Page, PlaneFrame, SMALL_FACES};

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
    /// Of a page's root, what is drawn of its boundary.
    kept: Kept,
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
            kept: Kept::default(),
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
        let thresholds = criterion.thresholds();
        let mut active = 0;
        let is_known = eager.is_some_and(|eager| {
            eager.show_of_page(page, thresholds.inactive, |local, rank| {
                active += usize::from(self.look_at(page, (local, thresholds.of(rank)), criterion));
            })
        });
        if is_known { Some(active) } else { self.look_at_all(page, criterion) }
    }

    #[inline]
    fn look_at(
        &mut self,
        page: &Page<'_>,
        (local, known): (u8, Option<bool>),
        criterion: &impl Criterion,
    ) -> bool {
        let Some((index, record)) = page.vertex(local) else { return false };
        let local = usize::from(local);
        let is_active = known.unwrap_or_else(|| criterion.activates(index, record));
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
        let [first, second, third, ..] = self.ring;
        if corners == 3 {
            let three = [first, second, third];
            show_triangle(
                three.map(|l| self.place(l)),
                three.map(|l| self.vertex[usize::from(l)]),
                &frame,
                mesh,
            );
            return Some(true);
        }
        let base = page.vertex(page.first_face(branch)?[0])?.1.position();
        let lay = Lay::of(&frame, self.place(first), base.map(|c| c * page.per_quantum()));
        let mut vertices = [0_u32; ROOM];
        for (four, locals) in self.ring.as_chunks::<4>().0.iter().enumerate().take(corners.div_ceil(4)) {
            let at = 4 * four;
            for (lane, local) in locals.iter().enumerate() {
                let local = usize::from(*local);
                self.best.x[at + lane] = self.x[local];
                self.best.y[at + lane] = self.y[local];
                self.best.height[at + lane] = self.z[local];
                vertices[at + lane] = self.vertex[local];
            }
            lay.four(&mut self.best, at);
        }
        Some(self.best.show(corners, |triangle| {
            mesh.indices.extend_from_slice(&triangle.map(|corner| vertices[corner % ROOM]));
        }))
    }

    /// The same for a page's root by what is known of its boundary; none, and nothing, if that is not enough.
    #[inline(never)]
    pub(crate) fn draw_root(
        &mut self,
        page: &Page<'_>,
        eager: &Table,
        criterion: &impl Criterion,
        mesh: &mut Mesh<'_>,
    ) -> Option<bool> {
        let draws =
            |vertex| page.record_of_vertex(vertex).is_some_and(|record| criterion.activates(vertex, record));
        if eager.keep_of_page(page, criterion.thresholds(), &mut self.kept, draws).is_none() {
            let _ = eager.fill_root(page);
            return None;
        }
        let (frame, bound) = page.plane(&page.whole())?;
        let vertices = self.kept.vertices();
        let corners = vertices.len();
        let is_simple = corners <= BEST_UP_TO && self.kept.ends().len() < 2;
        let Some(frame) = frame.filter(|_| is_simple && corners > 0) else {
            mesh.stats.bound = mesh.stats.bound.max(bound);
            return Some(corners == 0);
        };
        mesh.stats.bound = mesh.stats.bound.max(bound);
        let place =
            |vertex| page.record_of_vertex(vertex).map(|r| r.position().map(|c| c * page.per_quantum()));
        let first = place(vertices[0])?;
        if let [a, b, c] = *vertices {
            show_triangle([first, place(b)?, place(c)?], [a, b, c], &frame, mesh);
            return Some(true);
        }
        let lay = Lay::of(&frame, first, place(self.kept.first_corner)?);
        for (at, vertex) in vertices.iter().enumerate() {
            [self.best.x[at], self.best.y[at], self.best.height[at]] = place(*vertex)?;
        }
        for four in 0..corners.div_ceil(4) {
            lay.four(&mut self.best, 4 * four);
        }
        Some(self.best.show(corners, |triangle| {
            mesh.indices.extend_from_slice(&triangle.map(|corner| vertices[corner]));
        }))
    }

    #[inline]
    fn place(&self, local: u8) -> [f32; 3] {
        let local = usize::from(local);
        [self.x[local], self.y[local], self.z[local]]
    }

    /// What of a page's root's boundary is drawn, after [`PagePolygon::draw_root`].
    pub(crate) fn kept(&self) -> &Kept {
        &self.kept
    }

    /// Leaves all active loops of a branch in `out`; false if its vertices come in another order than elsewhere.
    pub(crate) fn read_loops(&self, page: &Page<'_>, branch: &Branch, out: &mut Loops) -> bool {
        out.clear();
        let is_read = page.rings(branch, |entries| {
            let start = out.vertices.len();
            for &local in entries {
                let local = usize::from(local);
                if self.state[local] == 1 {
                    out.vertices.push(self.vertex[local]);
                }
            }
            if out.vertices.len() < start + 3 {
                out.vertices.truncate(start);
            } else {
                out.ends.push(out.vertices.len());
            }
        });
        is_read.is_some() && branch.face_count() > SMALL_FACES
    }

    /// The number of triangles of a branch of two faces or more; nothing in it where only drawing tells, none if the page
    /// does not have what it says.
    pub(crate) fn count(&mut self, page: &Page<'_>, branch: &Branch) -> Option<Option<u64>> {
        Some(match self.thin(page, branch)? {
            Rings::None => Some(0),
            Rings::Several => None,
            Rings::One(corners) => {
                let mut passed = [0_u64; 4];
                let is_new = |local: &u8| {
                    let (word, bit) = (usize::from(local / 64), 1 << (local % 64));
                    let is_new = passed[word] & bit == 0;
                    passed[word] |= bit;
                    is_new
                };
                let are_all = self.ring.iter().take(corners).all(is_new);
                are_all.then_some(corners as u64 - 2)
            }
        })
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
}

/// How places of a polygon are laid into the plane along the axis of its cone.
struct Lay<'a> {
    /// The first corner: from there on places of small polygons far from the origin lose no digits.
    origin: [f32; 3],
    frame: &'a PlaneFrame,
    /// Across the plane that fits best, and its height there.
    across: [f32; 3],
    level: f32,
}

impl<'a> Lay<'a> {
    /// `base` is the first corner of the cluster's first face.
    #[inline(always)]
    fn of(frame: &'a PlaneFrame, origin: [f32; 3], base: [f32; 3]) -> Lay<'a> {
        let [tangent, other, axis] = frame.axes;
        let [u, v] = frame.lean;
        let across = sum(axis, sum(times(u, tangent), times(v, other)));
        let level = dot(minus(base, origin), across) + frame.height * frame.length;
        Lay { origin, frame, across, level }
    }

    /// Lays the places of four corners.
    #[inline(always)]
    fn four(&self, best: &mut Best, at: usize) {
        let [tangent, other, _] = self.frame.axes;
        let Best { x, y, height, .. } = best;
        for i in at..at + 4 {
            let d = minus([x[i], y[i], height[i]], self.origin);
            x[i] = dot(d, tangent);
            y[i] = dot(d, other);
            height[i] = dot(d, self.across) - self.level;
        }
    }
}

/// Appends a polygon of three corners.
#[inline]
fn show_triangle([a, b, c]: [[f32; 3]; 3], vertices: [u32; 3], frame: &PlaneFrame, mesh: &mut Mesh<'_>) {
    mesh.indices.extend_from_slice(&vertices);
    let [tangent, other, _] = frame.axes;
    let (u, v) = (minus(b, a), minus(c, a));
    let twice_area = dot(u, tangent) * dot(v, other) - dot(v, tangent) * dot(u, other);
    mesh.stats.folded += u64::from(twice_area < 0.0);
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
