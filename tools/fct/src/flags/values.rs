//! Numbers and places as they are typed.

use crate::export::{Ball, Scale};

fn number(text: &str) -> Option<f64> {
    text.trim().parse::<f64>().ok().filter(|x| x.is_finite())
}

pub(super) fn length(text: &str) -> Result<Scale, String> {
    let not_negative = |text| number(text).filter(|x| *x >= 0.0);
    let length = match text.trim().strip_suffix('%') {
        Some(percent) => not_negative(percent).map(|p| Scale::Diagonal(p / 100.0)),
        None => not_negative(text).map(Scale::Length),
    };
    length.ok_or_else(|| "expected a distance, 0 or more, or a percentage such as 0.1%".to_owned())
}

pub(super) fn square(text: &str) -> Result<f64, String> {
    number(text).filter(|x| *x >= 0.0).ok_or_else(|| "expected a number, 0 or more".to_owned())
}

pub(super) fn positive(text: &str) -> Result<f64, String> {
    number(text).filter(|x| *x > 0.0).ok_or_else(|| "expected a number above 0".to_owned())
}

pub(super) fn triangles(text: &str) -> Result<u64, String> {
    count(text).ok_or_else(|| "expected a number of triangles, 1 or more".to_owned())
}

pub(super) fn clusters(text: &str) -> Result<u64, String> {
    count(text).ok_or_else(|| "expected a number of clusters, 1 or more".to_owned())
}

pub(super) fn height(text: &str) -> Result<u32, String> {
    count(text)
        .and_then(|n| u32::try_from(n).ok())
        .ok_or_else(|| "expected a number of pixels, 1 or more".to_owned())
}

fn count(text: &str) -> Option<u64> {
    text.trim().parse().ok().filter(|n| *n > 0)
}

pub(super) fn field_of_view(text: &str) -> Result<f64, String> {
    number(text)
        .filter(|x| (1.0..=170.0).contains(x))
        .ok_or_else(|| "expected degrees from 1 to 170".to_owned())
}

pub(super) fn point(text: &str) -> Result<[f64; 3], String> {
    let numbers: Option<Vec<f64>> = text.split(',').map(number).collect();
    numbers
        .and_then(|n| <[f64; 3]>::try_from(n).ok())
        .ok_or_else(|| "expected three numbers such as 0,1.5,-2".to_owned())
}

pub(super) fn ball(text: &str) -> Result<Ball, String> {
    let numbers = |(ball, distance): (&str, &str)| {
        let numbers: Option<Vec<f64>> = ball.split(',').chain([distance]).map(number).collect();
        <[f64; 5]>::try_from(numbers?).ok()
    };
    let [x, y, z, radius, distance] = text
        .split_once('=')
        .and_then(numbers)
        .filter(|[.., radius, distance]| *radius > 0.0 && *distance >= 0.0)
        .ok_or_else(|| "expected a place, a radius and an error such as 0,1.5,-2,0.5=0.01".to_owned())?;
    Ok(Ball { center: [x, y, z], radius, distance })
}
