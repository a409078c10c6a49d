//! That pages own what they say, one after the other, and have grids that are exact.

use zerocopy::little_endian::U32;

use crate::error::Violation;
use crate::records::{MAX_PAGE_FACES, MAX_PAGE_VERTICES, PageRecord, unpack};
use crate::rule::Rule;
use crate::walk::{Reader, to_index};

/// A coordinate of the grid is at most so many steps from zero, where single precision still tells every step.
const MOST_STEPS: f64 = 16_777_216.0;

/// What the pages so far own.
#[derive(Clone, Copy, Default)]
struct Owned {
    faces: u32,
    vertices: u32,
    links: u32,
    loops: u32,
}

/// Checks all pages, and the links that they use.
pub(crate) fn check(reader: &Reader<'_>) -> Result<(), Box<Violation>> {
    let mut owned = Owned::default();
    for (index, page) in reader.pages.iter().enumerate() {
        let check = || {
            check_grid(page)?;
            check_place(page, &owned)?;
            check_names(page, reader)
        };
        check()
            .map_err(|(rule, found)| Violation::new(rule, format!("section PAGE, page {index}"), found))?;
        owned = Owned {
            faces: owned.faces.saturating_add(page.faces.into()),
            vertices: owned.vertices.saturating_add(page.own_vertices.get().into()),
            links: owned.links.saturating_add(page.links.get().into()),
            loops: owned.loops.saturating_add(page.loop_bytes.get().into()),
        };
    }
    let ends = [
        ("FACE", owned.faces, reader.faces.len()),
        ("VERT", owned.vertices, reader.vertices.len()),
        ("LINK", owned.links, reader.links.len()),
        ("LOOP", owned.loops, reader.loops.len()),
    ];
    for (section, owned, all) in ends {
        if to_index(owned) != Some(all) {
            return Err(Violation::new(
                if section == "LOOP" { Rule::LoopCover } else { Rule::PageRange },
                format!("section {section}"),
                format!("the pages own {owned} of its {all} elements"),
            ));
        }
    }
    Ok(())
}

type Broken = (Rule, String);

fn check_grid(page: &PageRecord) -> Result<(), Broken> {
    let quantum = page.quantum.get();
    let is_power = quantum > 0.0 && quantum.is_finite() && has_one_digit(quantum);
    let exact = unpack(page.origin).into_iter().all(|x| {
        let steps = f64::from(x) / f64::from(quantum);
        // Written so that NaN fails.
        steps.fract() == 0.0 && steps.abs() <= MOST_STEPS && (steps + 255.0).abs() <= MOST_STEPS
    });
    if is_power && exact {
        return Ok(());
    }
    Err((Rule::Grid, format!("its quantum is {quantum:e} and its grid begins at {:?}", unpack(page.origin))))
}

/// Whether a positive finite number is a power of two.
fn has_one_digit(x: f32) -> bool {
    let bits = x.to_bits();
    let digits = bits & 0x007F_FFFF;
    // Below the normal numbers the digits have no leading one of their own.
    if bits >> 23 == 0 { digits.is_power_of_two() } else { digits == 0 }
}

fn check_place(page: &PageRecord, owned: &Owned) -> Result<(), Broken> {
    if page.reserved != 0 {
        return Err((Rule::ReservedZero, format!("its reserved byte is {:#x}", page.reserved)));
    }
    let vertices = u32::from(page.own_vertices.get()).saturating_add(page.links.get().into());
    let faces = u32::from(page.faces);
    if !(1..=MAX_PAGE_FACES).contains(&faces) || vertices > MAX_PAGE_VERTICES {
        return Err((Rule::PageRange, format!("it has {faces} faces and {vertices} vertices")));
    }
    let begins = [
        ("faces", page.first_face, owned.faces),
        ("vertices", page.first_vertex, owned.vertices),
        ("links", page.first_link, owned.links),
        ("loops", page.first_loop, owned.loops),
    ];
    for (what, begins, before) in begins {
        if begins.get() != before {
            let found =
                format!("its {what} begin at {begins}, and those of the pages before it end at {before}");
            return Err((Rule::PageRange, found));
        }
    }
    Ok(())
}

/// Checks that the links ascend before the page's own vertices, and that the faces use each vertex of the page.
fn check_names(page: &PageRecord, reader: &Reader<'_>) -> Result<(), Broken> {
    let run = |first: U32, count: u32| {
        let first = to_index(first.get())?;
        Some(first..first.checked_add(to_index(count)?)?)
    };
    let links = run(page.first_link, page.links.get().into()).and_then(|r| reader.links.get(r));
    let faces = run(page.first_face, page.faces.into()).and_then(|r| reader.faces.get(r));
    let (Some(links), Some(faces)) = (links, faces) else {
        return Err((Rule::PageRange, "its faces or links are not there".to_owned()));
    };
    let ascending = links.windows(2).all(|pair| matches!(pair, [a, b] if a.get() < b.get()));
    let before = links.last().is_none_or(|l| l.get() < page.first_vertex.get());
    if !(ascending && before) {
        return Err((Rule::LinkOrder, "its links do not ascend, or name its own vertices".to_owned()));
    }
    let count = usize::from(page.own_vertices.get()).saturating_add(links.len());
    let mut used = [false; MAX_PAGE_VERTICES as usize];
    for local in faces.iter().flat_map(|f| f.vertices) {
        if let Some(used) = used.get_mut(usize::from(local)) {
            *used = true;
        }
    }
    if used.get(..count).is_none_or(|page| page.iter().any(|used| !used)) {
        return Err((Rule::LinkOrder, format!("its faces do not use all of its {count} vertices")));
    }
    Ok(())
}
