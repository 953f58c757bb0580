//! Each pass against its CPU twin, on whatever device there is (a software Vulkan is enough).
//!
//! Without any device the tests say so and pass; with `PLENOSCOPE_NEED_GPU` set they fail.

#![cfg(feature = "ui")]

mod common;

use std::sync::Arc;

use common::{Approx, two_planes};
use glam::{EulerRot, Quat, Vec3};
use plenoscope::field::color::{srgb_from_linear, srgb8_from_linear};
use plenoscope::field::{
    DisparityMap, EpiLine, FNumber, FocalPlane, Lens, LensShape, Opening, Photo, Strength, ViewGrid, ViewIndex,
    ViewOffset, ViewPoint,
};
use plenoscope::job::{Cancel, Job};
use plenoscope::render::gpu::{Draw, FieldTexture, Gpu, Target};
use plenoscope::render::lens::{LensGpu, Prepared, Region, Rgbd};
use plenoscope::render::{Picture, cpu};
use plenoscope::splats::{Blend, Camera, Cloud, Gaussian, NamedCamera, Processor, Rig, SplatGpu, Stage, harmonics};

const SIZE: [u32; 2] = [45, 31];

fn gpu(max_layers: u32) -> Option<Gpu> {
    let instance = wgpu::Instance::default();
    let adapter = pollster::block_on(instance.request_adapter(&Default::default()));
    let Ok(adapter) = adapter else {
        assert!(std::env::var_os("PLENOSCOPE_NEED_GPU").is_none(), "no device, and PLENOSCOPE_NEED_GPU is set");
        eprintln!("SKIPPED: no device here; install a Vulkan driver (mesa-vulkan-drivers) to check the shaders");
        return None;
    };
    let limits = wgpu::Limits { max_texture_array_layers: max_layers, ..wgpu::Limits::default() };
    let descriptor = wgpu::DeviceDescriptor { required_limits: limits, ..Default::default() };
    let (device, queue) = pollster::block_on(adapter.request_device(&descriptor)).expect("the device opens");
    Some(Gpu::new(&device, &queue, true))
}

/// Draws a picture on the device and reads it back.
fn drawn(gpu: &Gpu, field: &FieldTexture, draw: Draw) -> Picture {
    let size = draw.size(field.grid(), field.size());
    let mut target = Target::new(gpu, size);
    assert!(target.update(gpu, field, &draw), "it is drawn the first time");
    assert!(!target.update(gpu, field, &draw), "and not again");
    let row_bytes = (size[0] * 16).next_multiple_of(256);
    let buffer = gpu.device().create_buffer(&wgpu::BufferDescriptor {
        label: None,
        size: u64::from(row_bytes * size[1]),
        usage: wgpu::BufferUsages::COPY_DST | wgpu::BufferUsages::MAP_READ,
        mapped_at_creation: false,
    });
    let mut encoder = gpu.device().create_command_encoder(&Default::default());
    encoder.copy_texture_to_buffer(
        target.linear_texture().as_image_copy(),
        wgpu::TexelCopyBufferInfo {
            buffer: &buffer,
            layout: wgpu::TexelCopyBufferLayout { offset: 0, bytes_per_row: Some(row_bytes), rows_per_image: None },
        },
        target.linear_texture().size(),
    );
    gpu.queue().submit([encoder.finish()]);
    buffer.slice(..).map_async(wgpu::MapMode::Read, |result| result.expect("the buffer maps"));
    gpu.device().poll(wgpu::PollType::wait_indefinitely()).expect("the device answers");
    let bytes = buffer.slice(..).get_mapped_range().expect("mapped").to_vec();
    let row = |y: u32| &bytes[(y * row_bytes) as usize..][..size[0] as usize * 16];
    let values: Vec<f32> = (0..size[1]).flat_map(|y| bytemuck::pod_collect_to_vec::<u8, f32>(row(y))).collect();
    Picture { size, rgb_linear: values.chunks_exact(4).flat_map(|p| [p[0], p[1], p[2]]).collect() }
}

fn compare(gpu: &Gpu, field: &FieldTexture, what: &str, draw: Draw, want: &Picture) {
    let got = drawn(gpu, field, draw);
    assert_eq!(got.size, want.size, "{what}");
    // The device decodes sRGB texels by itself, and a software one does so to about 1e-3: fast maths, not ours.
    Approx::Fast.check(what, &got.rgb_linear, &want.rgb_linear);
}

fn check_all(gpu: &Gpu, grid: ViewGrid) {
    let (field, depths) = two_planes(grid, SIZE);
    let texture = FieldTexture::whole(gpu, &field, Some(&depths)).expect("small views fit");
    for (f, disparity, keep) in [(28.0, 0.0, 0.0), (3.5, 0.37, 0.0), (5.0, -0.4, 0.6)] {
        let focus = FocalPlane { disparity_px: disparity, tilt_px: [0.2, -0.1] };
        let lens = Lens { f_number: FNumber(f), focus, keep_sharp_px: [-keep, keep], ..Lens::default() };
        let center = ViewPoint(ViewOffset { dv: 0.25, du: -0.5 });
        let want = cpu::refocus_with_depths(&field, Some(&depths), &lens, center);
        let strewn = cpu::refocus_strewn(&field, &depths, &lens, center);
        let draw = |is_strewn| Draw::Refocus { lens: lens.clone(), center, is_draft: false, is_strewn };
        compare(gpu, &texture, "refocus", draw(false), &want);
        compare(gpu, &texture, "refocus, strewn", draw(true), &strewn);
    }
    for (dv, du) in [(0.0, 0.0), (-1.3, 0.6)] {
        let point = ViewPoint(ViewOffset { dv, du });
        compare(gpu, &texture, "view", Draw::View(point), &cpu::view_with_depths(&field, Some(&depths), point));
    }
    for line in [EpiLine::Row { y: 12, v: 1 }, EpiLine::Column { x: 30, u: 2 }] {
        compare(gpu, &texture, "epi", Draw::Epi { line, scale: 3 }, &cpu::epi(&field, line, 3));
    }
    let view = ViewIndex { v: 1, u: 2 };
    for map in cpu::Colormap::ALL {
        let want = cpu::depth(&depths, view, [-0.5, 1.0], map);
        compare(gpu, &texture, "depth", Draw::Depth { view, range: [-0.5, 1.0], map }, &want);
    }
}

#[test]
fn passes_match_their_twins() {
    if let Some(gpu) = gpu(256) {
        check_all(&gpu, ViewGrid::PAPER);
    }
}

#[test]
fn a_grid_of_more_views_than_layers_is_split() {
    if let Some(gpu) = gpu(256) {
        check_all(&gpu, ViewGrid::new(17, 17).expect("the largest grid"));
    }
}

#[test]
fn a_picture_is_right_while_views_arrive() {
    let Some(gpu) = gpu(256) else { return };
    let (field, _) = two_planes(ViewGrid::PAPER, SIZE);
    let mut texture = FieldTexture::new(&gpu, field.grid(), field.size()).expect("small views fit");
    let reference = field.grid().reference();
    texture.push_view(reference, field.reference());
    assert!(!texture.upload_some(&gpu, plenoscope::render::gpu::Budget::default()));
    let draw = Draw::Refocus { lens: Lens::default(), center: ViewPoint::default(), is_draft: false, is_strewn: false };
    // One view has arrived, so the widest lens shows that view at its full light.
    compare(&gpu, &texture, "one view", draw, &cpu::view(&field, ViewPoint::default()));
}

/// A near post and a bright dot before a slanted, textured ground.
fn posts(size: [u32; 2]) -> Prepared {
    let is_post = |x: u32, y: u32| (40..64).contains(&x) && y < 90;
    let light = |x: u32, y: u32| match (is_post(x, y), (x, y) == (110, 30)) {
        (_, true) => [1.0; 3],
        (true, _) => [0.6, 0.1 + 0.3 * ((x + 2 * y) % 7) as f32 / 7.0, 0.1],
        _ => [0.1, 0.3 + 0.2 * (y as f32 * 0.4).sin(), 0.3 + 0.2 * (x as f32 * 0.7).cos()],
    };
    let all = || (0..size[1]).flat_map(|y| (0..size[0]).map(move |x| (x, y)));
    let rgba = all().flat_map(|(x, y)| {
        let [r, g, b] = light(x, y).map(srgb8_from_linear);
        [r, g, b, 255]
    });
    let photo = Photo::from_srgb8(size, rgba.collect()).expect("a photo");
    let ground = |x: u32| -1.2 + 1.4 * x as f32 / size[0] as f32;
    let map = all().map(|(x, y)| if is_post(x, y) { 1.0 } else { ground(x) }).collect();
    let map = DisparityMap::new(size, map).expect("a map");
    Rgbd::new(Arc::new(photo), map).expect("a scene").prepare(size, &Cancel::default()).expect("nobody stops it")
}

#[test]
fn r9_the_lens_renderer_is_the_same_on_the_device() {
    let Some(gpu) = gpu(256) else { return };
    let size = [160, 120];
    let prepared = Arc::new(posts(size));
    let mut lens_gpu = LensGpu::new(gpu.device(), gpu.queue());
    let job = Job { cancel: &Cancel::default(), sink: &() };
    let blades = LensShape::Blades { count: 6, rotation_deg: 10.0, roundness: 0.4 };
    // Grey from left to right, closed at the upper right.
    let light = |i: u32| if i % 20 > i / 20 { 0.0 } else { (i % 20) as f32 + 1.0 };
    let steps = Opening::of_picture([20, 20], &(0..400).map(light).collect::<Vec<_>>()).expect("it is open");
    let whole = Region { at: [0; 2], size };
    let part = Region { at: [21, 13], size: [90, 77] };
    let cases = [
        (3.5, 0.0, LensShape::Disc, 0.0, whole),
        (2.0, 1.0, LensShape::Disc, 1.0, part),
        (1.2, -0.5, blades, 0.5, whole),
        (5.0, 0.4, LensShape::Square, 0.0, part),
        (2.8, -1.0, LensShape::Ring { inner: 0.5 }, 0.0, whole),
        (2.0, 0.3, LensShape::Picture(steps), 0.0, part),
    ];
    for (f, disparity_px, shape, highlights, region) in cases {
        let focus = FocalPlane { disparity_px, tilt_px: [0.1, -0.1] };
        let keep_sharp_px = [-0.1, 0.05];
        let lens = Lens { f_number: FNumber(f), focus, shape, highlights, keep_sharp_px, ..Lens::default() };
        let want = prepared.render(&lens, region, &job).expect("the CPU renders");
        let got = lens_gpu.render(&prepared, &lens, region, &job).expect("not stopped").expect("the device renders");
        assert_eq!(got.size, want.size);
        let stored = |light: f32| srgb_from_linear(light.clamp(0.0, 1.0)) * 255.0;
        let pairs = got.rgb_linear.iter().zip(&want.rgb_linear);
        let worst = pairs.map(|(a, b)| (stored(*a) - stored(*b)).abs()).fold(0.0, f32::max);
        assert!(worst <= 2.0, "f/{f} {:?}: {worst} of 255", lens.shape);
    }
    let cat_eye = Lens { shape: LensShape::CatEye { strength: 1.0 }, ..Lens::default() };
    assert!(lens_gpu.render(&prepared, &cat_eye, whole, &job).expect("not stopped").is_none());
}

/// A thousand Gaussians of all shapes, colours and opacities, with gaps between them.
fn thicket(size: [u32; 2]) -> Stage {
    let mut cloud = Cloud::with_room(0, 1000, Blend::Encoded);
    // Evenly over the unit cubes (Roberts's sequence), the same on every machine.
    let even = |i: u32, step: f32| (0.5 + step * i as f32).fract();
    for i in 0..1000 {
        let [x, y, z, t] = [0.8192, 0.6711, 0.5498, 0.4504].map(|step| even(i, step));
        let center = Vec3::new(2.4 * (x - 0.5), 2.4 * (y - 0.5), 1.0 + 3.0 * z);
        let scale = Vec3::new(0.02 + 0.08 * t, 0.02 + 0.05 * x, 0.01 + 0.04 * y);
        let rotation = Quat::from_euler(EulerRot::XYZ, 6.0 * x, 6.0 * y, 6.0 * t);
        let opacity = 0.1 + 0.9 * even(i, 0.3247);
        cloud.push(Gaussian { center, scale, rotation, opacity }, &[harmonics::constant([x, t, z])]);
    }
    let rig = Rig { camera: Camera::at_origin(90.0, size), step: 0.02, zero: 0.5, near: 0.1 };
    Stage { cloud, rig, named: NamedCamera::File, ends: [0.25, 1.0], in_metres: false }
}

#[test]
fn splats_are_the_same_on_the_device() {
    let Some(gpu) = gpu(256) else { return };
    // No multiple of a tile's side.
    let size = [101, 75];
    let stage = thicket(size);
    let device = SplatGpu::new(gpu.device(), gpu.queue());
    let job = Job { cancel: &Cancel::default(), sink: &() };
    let from = ViewPoint(ViewOffset { dv: 0.5, du: -1.0 });
    for (f, highlights) in [(28.0, 0.0), (2.8, 0.0), (1.4, 1.0)] {
        let lens = Lens { f_number: FNumber(f), highlights, ..Lens::default() };
        let how = (size, Strength::AS_MADE);
        let want = stage.through_lens(&lens, from, how, &Processor, &job).expect("not stopped");
        let got = stage.through_lens(&lens, from, how, &device, &job).expect("not stopped");
        let pairs = got.rgb_linear.iter().zip(&want.rgb_linear);
        let worst = pairs.map(|(a, b)| (a - b).abs()).fold(0.0, f32::max);
        let light = want.rgb_linear.iter().sum::<f32>() / want.rgb_linear.len() as f32;
        assert!(light > 0.05, "there is something to see: {light}");
        assert!(worst <= 1e-3, "f/{f}: {worst}");
    }
}

#[test]
fn splats_show_the_same_rays_on_the_device() {
    let Some(gpu) = gpu(256) else { return };
    let stage = thicket([101, 75]);
    let device = SplatGpu::new(gpu.device(), gpu.queue());
    let job = Job { cancel: &Cancel::default(), sink: &() };
    let view = ViewOffset { dv: 0.0, du: 2.0 };
    let want = stage.view(view, &Processor, &job).expect("not stopped");
    let got = stage.view(view, &device, &job).expect("not stopped");
    let apart = |a: &[f32], b: &[f32]| a.iter().zip(b).map(|(a, b)| (a - b).abs()).fold(0.0, f32::max);
    assert!(apart(&got.cover, &want.cover) <= 1e-3 && apart(&got.nearness, &want.nearness) <= 1e-3);
    assert!(want.cover.iter().any(|cover| *cover < 0.5), "there are gaps");
}
