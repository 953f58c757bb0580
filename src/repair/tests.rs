//! Repairs on made scenes whose true depth is known: a few clicks or strokes mend what a net got wrong.

use std::sync::Mutex;

use super::*;
use crate::field::{DisparityMap, FieldError, View};
use crate::job::{Cancel, Cancelled, Job, Progress, Sink, Stage};

const SIZE: [u32; 2] = [180, 120];
const WIDTH: f32 = SIZE[0] as f32;

/// The map with all repairs done to it, in a job that nobody stops or listens to.
fn alone(map: &DisparityMap, guide: Guide, repairs: &[Repair]) -> Result<DisparityMap, FieldError> {
    mended(map, guide, repairs, &Job { cancel: &Cancel::default(), sink: &() }).unwrap()
}

/// What is seen at a place: a colour, and the true disparity in pixels.
type Seen = ([f32; 3], f32);

/// A photo with even noise, its true map, and the map that is given, whose wrong part `wrong` changes.
struct Scene {
    guide: Guide,
    truth: DisparityMap,
    given: DisparityMap,
}

impl Scene {
    fn new(seen: impl Fn(f32, f32) -> Seen, wrong: impl Fn(f32, f32, f32) -> f32) -> Self {
        let places = (0..SIZE[0] * SIZE[1]).map(|i| [(i % SIZE[0]) as f32 + 0.5, (i / SIZE[0]) as f32 + 0.5]);
        let places: Vec<[f32; 2]> = places.map(|[x, y]| [x / WIDTH, y / SIZE[1] as f32]).collect();
        let mut noise = 7u32;
        let mut rgba = Vec::new();
        for [x, y] in &places {
            for c in seen(*x, *y).0 {
                noise = noise.wrapping_mul(1_664_525).wrapping_add(1_013_904_223);
                let grain = (noise >> 24) as f32 / 255.0 * 0.02 - 0.01;
                rgba.push(((c + grain).clamp(0.0, 1.0) * 255.0) as u8);
            }
            rgba.push(255);
        }
        let truth: Vec<f32> = places.iter().map(|[x, y]| seen(*x, *y).1).collect();
        let given = places.iter().zip(&truth).map(|([x, y], d)| wrong(*x, *y, *d)).collect();
        let map = |values| DisparityMap::new(SIZE, values).unwrap();
        let view = View::new(SIZE, rgba).unwrap();
        Self { guide: Guide::new(&view, SIZE), truth: map(truth), given: map(given) }
    }

    fn mended(&self, repairs: &[Repair]) -> DisparityMap {
        alone(&self.given, self.guide.clone(), repairs).unwrap()
    }

    /// Of the pixels that were wrong by more than a tenth of the range, the share that no longer is; and of those that
    /// were right, the share that was spoilt.
    fn judged(&self, repairs: &[Repair]) -> [f32; 2] {
        let mended = self.mended(repairs);
        let [low, high] = self.truth.range_px();
        let is_off = |map: &DisparityMap, i: usize| {
            (map.disparity_px()[i] - self.truth.disparity_px()[i]).abs() > 0.1 * (high - low)
        };
        let all = 0..self.truth.disparity_px().len();
        let (wrong, right): (Vec<_>, Vec<_>) = all.partition(|i| is_off(&self.given, *i));
        assert!(wrong.len() > 200, "{} pixels are wrong at first", wrong.len());
        let share =
            |of: &[usize], is: &dyn Fn(usize) -> bool| of.iter().filter(|i| is(**i)).count() as f32 / of.len() as f32;
        [share(&wrong, &|i| !is_off(&mended, i)), share(&right, &|i| is_off(&mended, i))]
    }

    #[track_caller]
    fn assert_mends(&self, repairs: &[Repair]) {
        assert!(repairs.len() <= 5);
        let [mended, spoilt] = self.judged(repairs);
        assert!(
            mended >= 0.9 && spoilt <= 0.01,
            "{mended} of the wrong pixels are right, {spoilt} of the others wrong"
        );
    }
}

const SKY: Seen = ([0.55, 0.7, 0.9], -0.8);
const PETAL: [f32; 3] = [0.9, 0.75, 0.2];

/// A flower before the sky: five petals and a head.
fn flower(x: f32, y: f32) -> Seen {
    let (dx, dy) = ((x - 0.5) * 1.5, y - 0.5);
    let (far, angle) = (dx.hypot(dy), dy.atan2(dx));
    if far < 0.1 {
        return ([0.35, 0.22, 0.1], 0.7);
    }
    let petal = (2.5 * angle).sin().abs();
    if far < 0.15 + 0.25 * petal { (PETAL, 0.6 + 0.3 * dx) } else { SKY }
}

fn click(at: Place, size: f32, what: Operation) -> Repair {
    Repair::Region { of: Region::Click { at, size }, what }
}

fn lasso(outline: &[Place], what: Operation) -> Repair {
    Repair::Region { of: Region::Lasso { outline: outline.to_vec(), snap: 0.02 }, what }
}

/// The right half of the right petal has the sky's depth.
fn petal_in_the_sky() -> Scene {
    let is_lost = |x: f32, y: f32| x > 0.63 && (y - 0.5).abs() < 0.14;
    Scene::new(flower, move |x, y, d| if is_lost(x, y) { SKY.1 } else { d })
}

fn petal_place() -> Place {
    // Petals point where |sin(2.5 a)| is largest: the first below the right.
    let angle = std::f32::consts::PI / 5.0;
    [0.5 + 0.25 * angle.cos() / 1.5, 0.5 + 0.25 * angle.sin()]
}

#[test]
fn half_a_petal_given_to_the_sky_joins_the_other_half() {
    let scene = petal_in_the_sky();
    let lost = |at: Place| scene.given.at((at[0] * WIDTH) as u32, (at[1] * SIZE[1] as f32) as u32) == SKY.1;
    let [x, y] = petal_place();
    let places = [[x + 0.01, y - 0.05], [x + 0.01, 1.0 - y + 0.05]];
    assert!(places.iter().all(|at| lost(*at)), "the places are in the lost halves");
    let repairs = places.map(|at| click(at, 0.3, Operation::Join));
    scene.assert_mends(&repairs);
}

#[test]
fn between_two_neighbours_of_its_colour_a_thing_joins_the_one_that_was_clicked_beside() {
    // A strip of one colour from left to right: near at the left, far at the right, and a part between at neither depth.
    let strip = |x: f32, y: f32| match x {
        _ if (y - 0.5).abs() > 0.1 => ([0.2, 0.3, 0.5], -0.8),
        x if x < 0.5 => (PETAL, 0.6),
        _ => (PETAL, -0.2),
    };
    let part = |x: f32, y: f32| (0.35..0.65).contains(&x) && (y - 0.5).abs() < 0.1;
    let scene = Scene::new(strip, |x, y, d| if part(x, y) { 0.2 } else { d });
    for (x, wanted) in [(0.39, 0.6), (0.61, -0.2)] {
        let mended = scene.mended(&[click([x, 0.5], 0.3, Operation::Join)]);
        let places = [0.4, 0.5, 0.6].map(|x| mended.at((x * WIDTH) as u32, SIZE[1] / 2));
        assert!(places.iter().all(|d| (d - wanted).abs() < 0.1), "clicked at {x}: {places:?}");
    }
}

#[test]
fn a_whole_petal_is_dragged_from_the_sky_by_its_epipolar_line_or_a_lasso() {
    let [px, py] = petal_place();
    let is_petal = move |x: f32, y: f32| {
        let seen = flower(x, y);
        seen.0 == PETAL && (x - px).hypot(y - py) < 0.2 && x > 0.5 && y > 0.52
    };
    let scene = Scene::new(flower, move |x, y, d| if is_petal(x, y) { SKY.1 } else { d });
    let to = flower(px, py).1 / WIDTH;
    scene.assert_mends(&[click([px, py], 0.35, Operation::To(to))]);
    let near = |dx: f32, dy: f32| [px + dx, py + dy];
    let outline = [near(-0.1, -0.12), near(0.14, -0.1), near(0.13, 0.2), near(-0.13, 0.12)];
    let by = to - SKY.1 / WIDTH;
    let [mended, spoilt] = scene.judged(&[lasso(&outline, Operation::Nearer(by))]);
    assert!(mended > 0.85, "a rough lasso brings {mended} back and spoils {spoilt}");
}

const BOTTLE: [f32; 3] = [0.1, 0.35, 0.15];

/// A bottle on a table before a wall.
fn bottle(x: f32, y: f32) -> Seen {
    let is_bottle = (x - 0.5).abs() < if y < 0.35 { 0.03 } else { 0.08 } && (0.15..0.8).contains(&y);
    let table = |y: f32| 4.0 * (y - 0.6);
    match () {
        () if is_bottle => (BOTTLE, table(0.8)),
        () if y > 0.55 => ([0.6, 0.45, 0.3], table(y)),
        () => ([0.8, 0.8, 0.78], table(0.55)),
    }
}

#[test]
fn a_bottle_that_leans_back_stands_upright_on_its_foot() {
    let leans = |x: f32, y: f32, d: f32| if bottle(x, y).0 == BOTTLE { d - 1.6 * (0.8 - y) } else { d };
    Scene::new(bottle, leans).assert_mends(&[click([0.5, 0.6], 0.6, Operation::Stand)]);
}

#[test]
fn a_bottle_given_to_the_wall_stands_on_what_is_below_it() {
    let lost = |x: f32, y: f32, d: f32| if bottle(x, y).0 == BOTTLE { bottle(0.0, 0.3).1 } else { d };
    Scene::new(bottle, lost).assert_mends(&[click([0.5, 0.6], 0.6, Operation::Stand)]);
}

#[test]
fn a_shadow_that_was_lifted_lies_on_the_table_again() {
    let is_shadow = |x: f32, y: f32| (x - 0.3).hypot((y - 0.78) * 0.6) < 0.09;
    let seen = move |x, y| {
        let (colour, d) = bottle(x, y);
        (if is_shadow(x, y) { [0.25, 0.18, 0.12] } else { colour }, d)
    };
    let lifted = move |x: f32, y: f32, d: f32| if is_shadow(x, y) { d + 0.5 } else { d };
    Scene::new(seen, lifted).assert_mends(&[click([0.3, 0.78], 0.4, Operation::Lie)]);
}

#[test]
fn a_sign_with_relief_that_is_none_becomes_flat() {
    let is_sign = |x: f32, y: f32| (0.3..0.7).contains(&x) && (0.25..0.6).contains(&y);
    let seen = move |x, y| if is_sign(x, y) { ([0.85, 0.2, 0.2], 0.5) } else { SKY };
    let bumpy = move |x: f32, y: f32, d: f32| if is_sign(x, y) { d + 0.3 * (30.0 * x).sin() } else { d };
    Scene::new(seen, bumpy).assert_mends(&[click([0.5, 0.4], 0.8, Operation::Flatten)]);
}

#[test]
fn strokes_even_out_bumps_and_bring_an_edge_to_the_photos() {
    let is_ball = |x: f32, y: f32| ((x - 0.5) * 1.5).hypot(y - 0.5) < 0.25;
    let seen = move |x, y| if is_ball(x, y) { ([0.8, 0.3, 0.3], 0.6) } else { ([0.3, 0.5, 0.3], -0.4) };
    let path = |points: &[Place]| points.to_vec();
    let speckled = move |x: f32, y: f32, d: f32| {
        let is_speck = ((x * 60.0) as u32).is_multiple_of(3) && ((y * 40.0) as u32).is_multiple_of(3);
        if is_ball(x, y) && is_speck { d - 0.35 } else { d }
    };
    let smooth = |y: f32| {
        let path = path(&[[0.3, y], [0.7, y]]);
        Repair::Stroke(Stroke { brush: Brush::Smooth, path, size: 0.25, strength: 1.0 })
    };
    Scene::new(seen, speckled).assert_mends(&[0.35, 0.45, 0.55, 0.65, 0.5].map(smooth));
    // The map's edge is four pixels outside of the photo's.
    let wide = move |x: f32, y: f32, d: f32| if ((x - 0.5) * 1.5).hypot(y - 0.5) < 0.283 { 0.6 } else { d };
    let ring = |i: u32| {
        let angle = i as f32 * std::f32::consts::TAU / 40.0;
        [0.5 + 0.265 * angle.cos() / 1.5, 0.5 + 0.265 * angle.sin()]
    };
    let round = Stroke { brush: Brush::Sharpen, path: (0..=40).map(ring).collect(), size: 0.12, strength: 1.0 };
    Scene::new(seen, wide).assert_mends(&[Repair::Stroke(round)]);
}

#[test]
fn a_brush_fills_a_hole_and_stops_at_the_things_edge() {
    let is_card = |x: f32, y: f32| (0.2..0.8).contains(&x) && (0.3..0.7).contains(&y);
    let seen = move |x, y| if is_card(x, y) { (PETAL, 0.5) } else { SKY };
    let holed = move |x: f32, y: f32, d: f32| if is_card(x, y) && (0.4..0.6).contains(&x) { SKY.1 } else { d };
    let nearer = |x: f32| {
        let path = vec![[x, 0.33], [x, 0.67]];
        Repair::Stroke(Stroke { brush: Brush::Nearer, path, size: 0.45, strength: 1.0 })
    };
    // A stroke moves by a third of a pixel at this width: four of them bring the card back.
    let scene = Scene::new(seen, holed);
    let [_, spoilt] = scene.judged(&[nearer(0.5), nearer(0.45), nearer(0.55), nearer(0.5)]);
    assert!(spoilt < 0.01, "{spoilt} was spoilt outside of the hole");
    let mended = scene.mended(&[nearer(0.5)]);
    assert!(
        (mended.at(90, 60) - (SKY.1 + WIDTH * FULL_STRENGTH)).abs() < 1e-4,
        "the middle moves by the full strength"
    );
    assert_eq!((mended.at(40, 60), mended.at(90, 20)), (scene.given.at(40, 60), scene.given.at(90, 20)));
}

#[test]
fn nothing_done_is_the_map_itself_and_the_order_counts() {
    let scene = petal_in_the_sky();
    assert_eq!(scene.mended(&[]), scene.given);
    let (flat, nearer) = (click([0.5, 0.5], 0.2, Operation::Flatten), click([0.5, 0.5], 0.2, Operation::Nearer(1e-3)));
    let join = click([0.68, 0.55], 0.3, Operation::Join);
    let (ab, ba) = (scene.mended(&[join.clone(), nearer.clone()]), scene.mended(&[nearer.clone(), join.clone()]));
    assert_eq!(ab, scene.mended(&[join.clone(), nearer.clone()]), "the same list is the same map");
    assert!(ab != scene.given && (ab != ba || flat != nearer));
    let list = Repairs::default();
    let list = [join, flat, nearer].into_iter().try_fold(list, |list, next| list.with(next, None)).unwrap();
    let all: Vec<Repair> = list.usable().cloned().collect();
    let kept: Vec<Repair> = list.without(1).usable().cloned().collect();
    assert_eq!(kept, [all[0].clone(), all[2].clone()]);
    assert_eq!(scene.mended(&kept), scene.mended(&[all[0].clone(), all[2].clone()]));
}

#[test]
fn the_same_repairs_mean_the_same_at_another_size() {
    let at = |size: [u32; 2]| {
        let pixel = |i: u32| {
            flower(((i % size[0]) as f32 + 0.5) / size[0] as f32, ((i / size[0]) as f32 + 0.5) / size[1] as f32)
        };
        let all: Vec<Seen> = (0..size[0] * size[1]).map(pixel).collect();
        let rgba = all.iter().flat_map(|(c, _)| [c[0], c[1], c[2], 1.0].map(|c| (c * 255.0) as u8)).collect();
        let map = all.iter().map(|(_, d)| d * size[0] as f32 / WIDTH).collect();
        let guide = Guide::new(&View::new(size, rgba).unwrap(), size);
        let repairs =
            [click([0.5, 0.5], 0.3, Operation::Farther(2e-3)), click([0.1, 0.1], 0.5, Operation::Nearer(1e-3))];
        alone(&DisparityMap::new(size, map).unwrap(), guide, &repairs).unwrap()
    };
    let (small, large) = (at(SIZE), at([360, 240]).resized(SIZE).unwrap());
    let pairs = small.disparity_px().iter().zip(large.disparity_px());
    let apart = pairs.filter(|(a, b)| (*a - *b).abs() > 0.05).count();
    assert!(apart < SIZE[0] as usize * SIZE[1] as usize / 50, "{apart} pixels differ");
}

#[test]
fn what_cannot_be_meant_changes_nothing_and_is_not_lost() {
    let scene = petal_in_the_sky();
    let stroke = |path: Vec<Place>, size: f32, strength: f32| {
        Repair::Stroke(Stroke { brush: Brush::Nearer, path, size, strength })
    };
    let wrong = [
        click([f32::NAN, 0.5], 0.1, Operation::Flatten),
        click([0.5, 0.5], f32::INFINITY, Operation::Flatten),
        click([0.5, 0.5], 0.1, Operation::Nearer(f32::NAN)),
        click([0.5, 0.5], 0.1, Operation::To(1e9)),
        click([1.7, 0.5], 0.1, Operation::Flatten),
        lasso(&[[0.1, 0.1], [0.2, 0.2]], Operation::Flatten),
        stroke(vec![[1.5, 1.5], [1.9, 1.2]], 0.1, 1.0),
        stroke(vec![], 0.1, 1.0),
        stroke(vec![[0.5; 2]; 5000], 0.1, 1.0),
        stroke(vec![[0.5, 0.5]], 0.1, f32::NAN),
    ];
    for repair in wrong {
        assert!(!repair.is_usable(), "{repair:?}");
        assert_eq!(scene.mended(std::slice::from_ref(&repair)), scene.given, "{repair:?}");
        assert!(Repairs::default().with(repair, None).is_none());
    }
    // Half beside the photo is fine, as is a ring around it.
    assert!(stroke(vec![[-0.2, 0.5], [0.2, 0.5]], 0.1, 1.0).is_usable());
    assert!(lasso(&[[-0.1, -0.1], [1.1, -0.1], [1.1, 1.1], [-0.1, 1.1]], Operation::Flatten).is_usable());
    for (w, h) in [(1, 1), (1, 7), (5, 1)] {
        let map = DisparityMap::constant([w, h], 0.3);
        let view = View::new([w, h], vec![90; (w * h * 4) as usize]).unwrap();
        let all = [Operation::Flatten, Operation::Stand, Operation::Lie, Operation::Join, Operation::To(0.0)];
        let mut repairs: Vec<Repair> = all.map(|what| click([0.5, 0.5], 0.5, what)).to_vec();
        repairs.extend(Brush::ALL.map(|brush| {
            Repair::Stroke(Stroke { brush, path: vec![[0.0, 0.0], [1.0, 1.0]], size: 0.5, strength: 1.0 })
        }));
        repairs.push(lasso(&[[0.0, 0.0], [1.0, 0.0], [1.0, 1.0]], Operation::Lie));
        assert!(alone(&map, Guide::new(&view, [w, h]), &repairs).is_ok());
    }
}

/// Keeps how far a job was.
#[derive(Default)]
struct Heard(Mutex<Vec<Progress>>);

impl Sink for Heard {
    fn progress(&self, progress: Progress) {
        self.0.lock().unwrap().push(progress);
    }
}

#[test]
fn mending_says_how_far_it_is_and_stops_within_a_stroke() {
    let (scene, cancel, heard) = (petal_in_the_sky(), Cancel::default(), Heard::default());
    let job = Job { cancel: &cancel, sink: &heard };
    let path = vec![[0.2, 0.5], [0.8, 0.5]];
    let stroke = Repair::Stroke(Stroke { brush: Brush::Nearer, path, size: 0.15, strength: 1.0 });
    let repairs = [stroke.clone(), stroke.clone()];
    assert!(mended(&scene.given, scene.guide.clone(), &repairs, &job).is_ok());
    let steps = heard.0.lock().unwrap().clone();
    assert_eq!(steps, [0, 1].map(|done| Progress { stage: Stage::Mend, done, total: 2 }));
    cancel.cancel();
    let mut mender = Mender::new(&scene.given, scene.guide.clone());
    assert_eq!(mender.apply(&stroke, &job), Err(Cancelled));
    assert_eq!(mender.disparity_px(), scene.given.disparity_px());
}

#[test]
fn a_stroke_is_the_same_however_many_points_it_has() {
    let scene = petal_in_the_sky();
    let stroke = |points: u32, brush: Brush| {
        let path = (0..=points).map(|i| [0.2 + 0.6 * i as f32 / points as f32, 0.5]).collect();
        scene.mended(&[Repair::Stroke(Stroke { brush, path, size: 0.15, strength: 0.8 })])
    };
    for brush in Brush::ALL {
        let (few, many) = (stroke(1, brush), stroke(60, brush));
        assert!(few != scene.given, "{brush:?}");
        let pairs = few.disparity_px().iter().zip(many.disparity_px());
        assert!(pairs.filter(|(a, b)| (*a - *b).abs() > 1e-3).count() < 60, "{brush:?}");
    }
}

#[test]
fn the_list_comes_back_from_its_file_with_what_it_does_not_know() {
    let text = r#"{"photo": "00", "list": [
        {"region": {"of": {"click": {"at": [0.5, 0.25], "size": 0.2}}, "do": {"nearer": 0.001}}},
        {"region": {"of": {"lasso": {"outline": [[0, 0], [1, 0], [1, 1]], "snap": 0.02}}, "do": "stand"}},
        {"stroke": {"brush": "sharpen", "path": [[0.1, 0.1]], "size": 0.05, "strength": 1}},
        {"warp": {"by": 3}},
        {"stroke": {"brush": "nearer", "path": [[0.1, 0.1]], "size": 0.05, "strength": 1, "pressure": [1]}},
        {"region": {"of": {"click": {"at": [0.5, 1e39], "size": 0.2}}, "do": "flatten"}}]}"#;
    let list: Repairs = serde_json::from_str(text).unwrap();
    assert_eq!((list.entries().len(), list.usable().count()), (6, 3));
    assert!(list.left_out().unwrap().contains("3 repairs"));
    let written = serde_json::to_value(&list).unwrap();
    let whole: serde_json::Value = serde_json::from_str(text).unwrap();
    assert_eq!(
        (3..6).map(|i| &written["list"][i]).collect::<Vec<_>>(),
        (3..6).map(|i| &whole["list"][i]).collect::<Vec<_>>()
    );
    assert_eq!(serde_json::from_value::<Repairs>(written).unwrap(), list);
    assert_eq!(list.without(3).without(3).without(3).left_out(), None);
    assert!(serde_json::from_str::<Repairs>(r#"{"list": 3}"#).is_err());
    let many: Vec<_> = (0..10_000)
        .map(|_| serde_json::json!({"stroke": {"brush": "smooth", "path": [[0.5, 0.5]], "size": 0.01, "strength": 1}}))
        .collect();
    let many: Repairs = serde_json::from_value(serde_json::json!({"list": many})).unwrap();
    assert_eq!((many.usable().count(), many.entries().len()), (MOST, 10_000));
    assert!(many.left_out().unwrap().contains("9000 repairs"));
    assert!(many.with(click([0.5, 0.5], 0.1, Operation::Flatten), None).is_none());
}

#[test]
fn a_photo_is_known_again_after_it_was_saved_anew_and_another_is_not() {
    let pixels = |shift: i32, noise: u32| {
        let mut state = 1u32;
        let mut rgba = Vec::new();
        for i in 0..160 * 100i32 {
            state = state.wrapping_mul(1_664_525).wrapping_add(1_013_904_223);
            let (x, y) = (i % 160 + shift, i / 160);
            let grain = (state >> 24) % (noise + 1);
            rgba.extend([(x.rem_euclid(160) + grain as i32) as u8, (y * 2) as u8, 60, 255]);
        }
        PhotoSign::of_pixels([160, 100], &rgba)
    };
    let list = Repairs::default().with(click([0.5, 0.5], 0.1, Operation::Flatten), Some(&pixels(0, 0))).unwrap();
    assert!(list.are_of(&pixels(0, 0)) && list.are_of(&pixels(0, 6)));
    assert!(!list.are_of(&pixels(80, 0)));
}
