//! Small balls, to find centres for spheres: nothing has to lie in them to the last digit.

/// A centre and a radius.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Ball {
    pub(super) center: [f64; 3],
    pub(super) radius: f64,
}

impl Ball {
    /// The smallest around a triangle.
    pub(super) fn of_triangle([p, q, r]: [[f32; 3]; 3]) -> Ball {
        let [p, q, r] = [p, q, r].map(|corner| corner.map(f64::from));
        let (a, b) = (minus(q, p), minus(r, p));
        let (aa, bb, ab) = (dot(a, a), dot(b, b), dot(a, b));
        let det = 2.0 * (aa * bb - ab * ab);
        // At a corner of 90 degrees and more: the ball across the side opposite.
        let (along_a, along_b) = if ab <= 0.0 {
            (0.5, 0.5)
        } else if aa <= ab || det <= 0.0 && aa <= bb {
            (0.0, 0.5)
        } else if bb <= ab || det <= 0.0 {
            (0.5, 0.0)
        } else {
            (bb * (aa - ab) / det, aa * (bb - ab) / det)
        };
        let away = [0, 1, 2].map(|k| a[k] * along_a + b[k] * along_b);
        let center = [0, 1, 2].map(|k| p[k] + away[k]);
        let radius =
            [p, q, r].into_iter().map(|corner| square(minus(corner, center))).fold(0.0, f64::max).sqrt();
        Ball { center, radius }
    }

    /// The smallest around two balls.
    pub(super) fn around(a: &Ball, b: &Ball) -> Ball {
        let d = minus(b.center, a.center);
        let distance = square(d).sqrt();
        // 0 at the centre of a, 1 at that of b, which is where it stays if one holds the other.
        let along = (distance + b.radius - a.radius) / (2.0 * distance);
        if along.is_nan() || along <= 0.0 {
            return *a;
        }
        if along >= 1.0 {
            return *b;
        }
        Ball {
            center: [0, 1, 2].map(|k| a.center[k] + d[k] * along),
            radius: 0.5 * (distance + a.radius + b.radius),
        }
    }

    /// A small ball around this one and the corners of a face, the farthest of which moves the centre most.
    pub(super) fn stretched_to(mut self, corners: &[[f32; 3]; 3]) -> Ball {
        for _ in corners {
            let mut farthest = (self.radius * self.radius, None);
            for corner in corners {
                let corner = corner.map(f64::from);
                let squared = square(minus(corner, self.center));
                if squared > farthest.0 * (1.0 + 1e-9) {
                    farthest = (squared, Some(corner));
                }
            }
            let Some(corner) = farthest.1 else { break };
            self = Ball::around(&self, &Ball { center: corner, radius: 0.0 });
        }
        self
    }

    /// A small ball around two faces.
    pub(super) fn of_faces(a: &[[f32; 3]; 3], b: &[[f32; 3]; 3]) -> Ball {
        Ball::of_triangle(*a).stretched_to(b)
    }
}

fn minus(a: [f64; 3], b: [f64; 3]) -> [f64; 3] {
    [a[0] - b[0], a[1] - b[1], a[2] - b[2]]
}

fn dot(a: [f64; 3], b: [f64; 3]) -> f64 {
    a[0] * b[0] + a[1] * b[1] + a[2] * b[2]
}

fn square(a: [f64; 3]) -> f64 {
    dot(a, a)
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    fn holds(ball: &Ball, corners: &[[f32; 3]; 3]) -> bool {
        corners.iter().all(|c| {
            square(minus(c.map(f64::from), ball.center)).sqrt() <= ball.radius * (1.0 + 1e-6) + 1e-30
        })
    }

    #[test]
    fn a_triangle_without_area_is_held() {
        for triangle in [
            [[1.0, 2.0, 3.0]; 3],
            [[0.0; 3], [1.0, 0.0, 0.0], [3.0, 0.0, 0.0]],
            [[0.0; 3], [4.0, 0.0, 0.0], [0.0; 3]],
        ] {
            assert!(holds(&Ball::of_triangle(triangle), &triangle), "{triangle:?}");
        }
    }

    proptest! {
        /// Never too small, and for a triangle no larger than it must be.
        #[test]
        fn balls_hold_what_they_are_around(
            a in prop::array::uniform3(prop::array::uniform3(-9.0_f32..9.0)),
            b in prop::array::uniform3(prop::array::uniform3(-9.0_f32..9.0)),
        ) {
            let ball = Ball::of_triangle(a);
            prop_assert!(holds(&ball, &a));
            let longest = [(0, 1), (1, 2), (2, 0)].map(|(i, k)| square(minus(a[i].map(f64::from), a[k].map(f64::from))).sqrt());
            let longest = longest.into_iter().fold(0.0, f64::max);
            // The widest is that of an equal-sided triangle.
            prop_assert!(ball.radius <= longest / 3.0_f64.sqrt() * (1.0 + 1e-6));
            let both = Ball::of_faces(&a, &b);
            prop_assert!(holds(&both, &a) && holds(&both, &b));
            let around = Ball::around(&ball, &Ball::of_triangle(b));
            prop_assert!(holds(&around, &a) && holds(&around, &b));
            prop_assert!(both.radius <= 1.3 * around.radius);
        }
    }
}
