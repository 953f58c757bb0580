//! Light that says nothing about depth: a picture falls off to one side, a lamp brightens a spot, a wall above burns out,
//! corners are dark, a veil lies over a part. Photos have all of it, and nets take it for depth where samples do not.

use crate::rng::Rng;

/// A smooth field over the picture, whose sides lie at −1 and 1: a slope, and waves of at most half a period.
struct Smooth {
    slope: [f32; 2],
    /// Height, periods along x and y, phase.
    waves: [[f32; 4]; 2],
}

impl Smooth {
    fn random(rng: &mut Rng, steep: f32, high: f32) -> Self {
        let mut wave = || [rng.range(-high, high), rng.range(-1.6, 1.6), rng.range(-1.6, 1.6), rng.range(0.0, 6.3)];
        let waves = [wave(), wave()];
        Self { slope: way(rng).map(|part| part * steep), waves }
    }

    fn at(&self, [x, y]: [f32; 2]) -> f32 {
        let wave = |[high, along, down, phase]: &[f32; 4]| high * (along * x + down * y + phase).sin();
        self.slope[0] * x + self.slope[1] * y + self.waves.iter().map(wave).sum::<f32>()
    }
}

/// A unit vector of any direction.
fn way(rng: &mut Rng) -> [f32; 2] {
    let (sin, cos) = rng.range(0.0, std::f32::consts::TAU).sin_cos();
    [cos, sin]
}

/// Light of a lamp, or a shadow, that fades from a middle outwards.
struct Spot {
    middle: [f32; 2],
    reach: [f32; 2],
    high: f32,
}

impl Spot {
    fn random(rng: &mut Rng) -> Self {
        let reach = rng.range(0.2, 0.9);
        Self {
            middle: [rng.range(-1.2, 1.2), rng.range(-1.2, 1.2)],
            reach: [reach * rng.range(0.6, 1.6), reach],
            high: rng.range(-0.7, 0.8),
        }
    }

    fn at(&self, at: [f32; 2]) -> f32 {
        let far: f32 = (0..2).map(|i| ((at[i] - self.middle[i]) / self.reach[i]).powi(2)).sum();
        self.high * (-far).exp()
    }
}

/// A side of the picture that burns out: a bright wall, a window.
struct Side {
    /// Into the side.
    into: [f32; 2],
    /// Where half of it is reached, and the width of the change.
    from: f32,
    wide: f32,
    most: f32,
    colour: [f32; 3],
}

impl Side {
    fn random(rng: &mut Rng) -> Self {
        let [x, y] = [[0.0, -1.0], [0.0, 1.0], [-1.0, 0.0], [1.0, 0.0]][rng.weighted(&[0.5, 0.2, 0.15, 0.15])];
        let (sin, cos) = rng.range(-0.3f32, 0.3).sin_cos();
        let white = rng.range(0.85, 1.0);
        Self {
            into: [x * cos - y * sin, x * sin + y * cos],
            from: rng.range(-0.3, 0.7),
            wide: rng.range(0.04, 0.6),
            most: rng.range(0.3, 0.95),
            colour: [white * rng.range(0.92, 1.0), white, white * rng.range(0.88, 1.0)],
        }
    }

    fn at(&self, [x, y]: [f32; 2]) -> f32 {
        let t = ((self.into[0] * x + self.into[1] * y - self.from) / self.wide + 0.5).clamp(0.0, 1.0);
        self.most * t * t * (3.0 - 2.0 * t)
    }
}

/// How one sample is lit besides.
pub struct Shade {
    /// Logarithm of the gain of sRGB values.
    gain: Smooth,
    spots: Vec<Spot>,
    /// Slope of each colour's own gain.
    cast: [[f32; 2]; 3],
    /// How dark corners are, and the middle that they lie about.
    corners: Option<(f32, [f32; 2])>,
    side: Option<Side>,
    /// A veil that knows no depth, and its colour.
    veil: Option<(Smooth, f32)>,
}

impl Shade {
    /// Any shade: always some fall of light, the rest by chance.
    pub fn random(rng: &mut Rng) -> Self {
        let (steep, high) = (rng.range(0.0, 0.5), if rng.chance(0.4) { 0.25 } else { 0.03 });
        let gain = Smooth::random(rng, steep, high);
        let spots = (0..rng.weighted(&[0.45, 0.35, 0.2])).map(|_| Spot::random(rng)).collect();
        let reach = if rng.chance(0.3) { 0.1 } else { 0.0 };
        let cast = std::array::from_fn(|_| [rng.range(-reach, reach), rng.range(-reach, reach)]);
        let corners = rng.chance(0.25).then(|| (rng.range(0.1, 0.45), [rng.range(-0.4, 0.4), rng.range(-0.4, 0.4)]));
        let side = rng.chance(0.3).then(|| Side::random(rng));
        let veil = rng.chance(0.2).then(|| {
            let steep = rng.range(0.1, 0.4);
            (Smooth::random(rng, steep, 0.15), rng.range(0.4, 0.95))
        });
        Self { gain, spots, cast, corners, side, veil }
    }

    /// Lights views `[view, channel, y, x]` of sRGB 0 … 1, all alike: it is the picture that is lit, not the things in it.
    pub fn apply(&self, rgb: &mut [f32], [w, h]: [usize; 2]) {
        let place = |i: usize, side: usize| 2.0 * i as f32 / (side.max(2) - 1) as f32 - 1.0;
        let places = (0..w * h).map(|i| [place(i % w, w), place(i / w, h)]);
        let lights: Vec<Light> = places.map(|at| self.at(at)).collect();
        for (plane, values) in rgb.chunks_exact_mut(w * h).enumerate() {
            for (value, light) in values.iter_mut().zip(&lights) {
                *value = light.of(*value, plane % 3);
            }
        }
    }

    fn at(&self, at: [f32; 2]) -> Light {
        let mut gain = self.gain.at(at) + self.spots.iter().map(|spot| spot.at(at)).sum::<f32>();
        if let Some((dark, middle)) = self.corners {
            gain -= dark * (0..2).map(|i| (at[i] - middle[i]).powi(2)).sum::<f32>();
        }
        let gains = self.cast.map(|[x, y]| (gain + x * at[0] + y * at[1]).exp());
        let veils = [
            self.veil.as_ref().map(|(amount, grey)| ((0.25 + amount.at(at)).clamp(0.0, 0.7), [*grey; 3])),
            self.side.as_ref().map(|side| (side.at(at), side.colour)),
        ];
        Light { gains, veils: veils.map(Option::unwrap_or_default) }
    }
}

/// What becomes of a colour at one place: gains, then veils one over the other.
struct Light {
    gains: [f32; 3],
    veils: [(f32, [f32; 3]); 2],
}

impl Light {
    fn of(&self, value: f32, channel: usize) -> f32 {
        let lit = (value * self.gains[channel]).min(1.0);
        self.veils.iter().fold(lit, |value, (amount, colour)| value + amount * (colour[channel] - value))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const SIZE: [usize; 2] = [24, 16];

    fn shaded(seed: u64, views: usize) -> Vec<f32> {
        let mut rgb = vec![0.5; views * 3 * SIZE[0] * SIZE[1]];
        Shade::random(&mut Rng::new(seed, 0)).apply(&mut rgb, SIZE);
        rgb
    }

    #[test]
    fn colours_stay_in_range_and_all_views_are_lit_alike() {
        for seed in 0..200 {
            let rgb = shaded(seed, 2);
            assert!(rgb.iter().all(|v| (0.0..=1.0).contains(v)), "{seed}");
            let (first, second) = rgb.split_at(rgb.len() / 2);
            assert_eq!(first, second);
        }
    }

    #[test]
    fn light_is_smooth_and_falls_to_any_side() {
        let [w, h] = SIZE;
        let mut falls = [0; 4];
        for seed in 0..400 {
            let rgb = shaded(seed, 1);
            let mean = |range: &dyn Fn(usize) -> bool| {
                let part: Vec<f32> = (0..w * h).filter(|i| range(*i)).map(|i| rgb[i]).collect();
                part.iter().sum::<f32>() / part.len() as f32
            };
            let down = mean(&|i| i / w < h / 2) - mean(&|i| i / w >= h / 2);
            let right = mean(&|i| i % w < w / 2) - mean(&|i| i % w >= w / 2);
            for (count, fall) in falls.iter_mut().zip([down, -down, right, -right]) {
                *count += usize::from(fall > 0.05);
            }
            let steep = (0..w * h - 1).filter(|i| i % w + 1 < w && (rgb[i + 1] - rgb[*i]).abs() > 0.5).count();
            assert_eq!(steep, 0, "{seed}");
        }
        assert!(falls.iter().all(|count| *count > 40), "{falls:?}");
    }
}
