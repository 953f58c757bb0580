//! The pictures of the window, on whatever device there is: `cargo bench --bench passes`.
//!
//! One line a picture at 270×187×8×8, the size of the paper's light fields. On a software device a drag has 16 ms.

use divan::Bencher;
use plenoscope::field::{
    EpiLine, FNumber, Lens, LightField, RayDepths, View, ViewGrid, ViewIndex, ViewOffset, ViewPoint,
};
use plenoscope::render::cpu::Colormap;
use plenoscope::render::gpu::{Draw, FieldTexture, Gpu, Target};

const SIZE: [u32; 2] = [270, 187];

fn main() {
    divan::main();
}

/// A device with a light field of noise on it.
fn device() -> Option<(Gpu, FieldTexture)> {
    let adapter = pollster::block_on(wgpu::Instance::default().request_adapter(&Default::default())).ok()?;
    let is_software = adapter.get_info().device_type == wgpu::DeviceType::Cpu;
    let (device, queue) = pollster::block_on(adapter.request_device(&Default::default())).ok()?;
    let gpu = Gpu::new(&device, &queue, is_software);
    let grid = ViewGrid::PAPER;
    let count = (SIZE[0] * SIZE[1]) as usize;
    let value = |i: usize| (i.wrapping_mul(2_654_435_761) >> 7) as u8;
    let view = |layer: usize| {
        let rgba = (0..count).flat_map(|i| [value(i + layer), value(i * 3 + layer), value(i * 7), 255]);
        View::new(SIZE, rgba.collect()).expect("a view").into()
    };
    let field = LightField::new(grid, (0..grid.count()).map(view).collect()).expect("a light field");
    let depths = (0..grid.count() * count).map(|i| f32::from(value(i)) / 128.0 - 1.0).collect();
    let depths = RayDepths::new(grid, SIZE, depths).expect("ray depths").into();
    let texture = FieldTexture::whole(&gpu, &field, Some(&depths))?;
    Some((gpu, texture))
}

/// Draws pictures that differ from each other, so that none is taken from the last time.
fn time(bencher: Bencher, draw: impl Fn(f32) -> Draw) {
    let Some((gpu, field)) = device() else { return };
    let mut target = Target::new(&gpu, draw(0.0).size(field.grid(), field.size()));
    let mut turn = 0;
    bencher.bench_local(|| {
        turn = (turn + 1) % 50;
        target.update(&gpu, &field, &draw(turn as f32 / 25.0 - 1.0));
        gpu.device().poll(wgpu::PollType::wait_indefinitely()).expect("the device answers");
    });
}

fn eye(at: f32) -> ViewPoint {
    ViewPoint(ViewOffset { dv: at, du: 0.3 - at })
}

#[divan::bench]
fn view(bencher: Bencher) {
    time(bencher, |at| Draw::View(eye(at)));
}

#[divan::bench(args = [14.0, 7.0, 3.5])]
fn refocus(bencher: Bencher, f_number: f32) {
    let lens = Lens { f_number: FNumber(f_number), ..Lens::default() };
    time(bencher, |at| Draw::Refocus { lens: lens.clone(), center: eye(at), is_draft: false, is_strewn: false });
}

/// What is drawn under the hand on a software device.
#[divan::bench(args = [14.0, 7.0, 3.5])]
fn refocus_draft(bencher: Bencher, f_number: f32) {
    let lens = Lens { f_number: FNumber(f_number), ..Lens::default() };
    time(bencher, |at| Draw::Refocus { lens: lens.clone(), center: eye(at), is_draft: true, is_strewn: false });
}

/// The same where copies would be seen.
#[divan::bench(args = [14.0, 7.0, 3.5])]
fn refocus_strewn(bencher: Bencher, f_number: f32) {
    let lens = Lens { f_number: FNumber(f_number), ..Lens::default() };
    time(bencher, |at| Draw::Refocus { lens: lens.clone(), center: eye(at), is_draft: true, is_strewn: true });
}

#[divan::bench]
fn epi(bencher: Bencher) {
    time(bencher, |at| Draw::Epi { line: EpiLine::Row { y: (90.0 + 50.0 * at) as u32, v: 4 }, scale: 8 });
}

#[divan::bench]
fn depth(bencher: Bencher) {
    let view = ViewIndex { v: 4, u: 4 };
    time(bencher, |at| Draw::Depth { view, range: [-1.0, 1.0 + at / 10.0], map: Colormap::Turbo });
}
