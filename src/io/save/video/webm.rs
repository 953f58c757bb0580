//! WebM (Matroska) with one AV1 track: a cluster for each frame that can be jumped to, and cues that find them.

use std::io::{self, Write};

use super::Film;

/// Writes the file.
pub(super) fn write(out: &mut dyn Write, film: &Film) -> io::Result<()> {
    let head = [
        uint(0x4286, 1),
        uint(0x42f7, 1),
        uint(0x42f2, 4),
        uint(0x42f3, 8),
        element(0x4282, b"webm"),
        uint(0x4287, 4),
        uint(0x4285, 2),
    ];
    out.write_all(&element(0x1a45_dfa3, &head.concat()))?;
    let [info, tracks] = [info(film), tracks(film)];
    let clusters: Vec<(u64, Vec<u8>)> = clusters(film);
    // Cues name places after themselves; the length of their numbers is fixed.
    let before = info.len() + tracks.len() + cues(&clusters, 0).len();
    let segment = [info, tracks, cues(&clusters, before as u64)].concat();
    let bytes = segment.len() + clusters.iter().map(|(_, cluster)| cluster.len()).sum::<usize>();
    out.write_all(&id(0x1853_8067))?;
    out.write_all(&length(bytes))?;
    out.write_all(&segment)?;
    clusters.iter().try_for_each(|(_, cluster)| out.write_all(cluster))
}

/// An element's name, which says its own length.
fn id(name: u32) -> Vec<u8> {
    name.to_be_bytes().into_iter().skip_while(|&byte| byte == 0).collect()
}

/// A length in eight bytes.
fn length(bytes: usize) -> [u8; 8] {
    (bytes as u64 | 1 << 56).to_be_bytes()
}

fn element(name: u32, content: &[u8]) -> Vec<u8> {
    [&id(name), &length(content.len())[..], content].concat()
}

fn uint(name: u32, value: u64) -> Vec<u8> {
    element(name, &value.to_be_bytes())
}

fn info(film: &Film) -> Vec<u8> {
    let parts = [
        uint(0x2a_d7b1, 1_000_000),
        element(0x4489, &film.duration_ms().to_be_bytes()),
        element(0x4d80, b"Plenoscope"),
        element(0x5741, b"Plenoscope"),
    ];
    element(0x1549_a966, &parts.concat())
}

fn tracks(film: &Film) -> Vec<u8> {
    let [width, height] = film.size.map(u64::from);
    // Matrix, range (broadcast), curve and primaries: as in the sequence header.
    let colors = [uint(0x55b1, 1), uint(0x55b9, 1), uint(0x55ba, 13), uint(0x55bb, 1)].concat();
    let picture = [uint(0xb0, width), uint(0xba, height), element(0x55b0, &colors)].concat();
    let frame_ns = 1_000_000_000 / u64::from(film.frames_per_second);
    let track = [
        uint(0xd7, 1),
        uint(0x73c5, 1),
        uint(0x83, 1),
        uint(0x9c, 0),
        uint(0x23_e383, frame_ns),
        element(0x86, b"V_AV1"),
        element(0x63a2, &film.codec),
        element(0xe0, &picture),
    ];
    element(0x1654_ae6b, &element(0xae, &track.concat()))
}

/// The clusters with their times in milliseconds.
fn clusters(film: &Film) -> Vec<(u64, Vec<u8>)> {
    let time = |number: usize| (number as f64 * 1000.0 / f64::from(film.frames_per_second)).round() as u64;
    let starts: Vec<usize> =
        film.frames.iter().enumerate().filter(|(n, frame)| frame.is_key || *n == 0).map(|(n, _)| n).collect();
    let ends = starts.iter().skip(1).copied().chain([film.frames.len()]);
    let cluster = |(from, to): (&usize, usize)| {
        let start = time(*from);
        let mut content = uint(0xe7, start);
        for (number, frame) in film.frames.iter().enumerate().take(to).skip(*from) {
            let after = (time(number) - start) as i16;
            let flags = if frame.is_key { 0x80 } else { 0 };
            content.extend(element(0xa3, &[&[0x81][..], &after.to_be_bytes(), &[flags], &frame.data].concat()));
        }
        (start, element(0x1f43_b675, &content))
    };
    starts.iter().zip(ends).map(cluster).collect()
}

/// Where each cluster is, counted from the segment's content.
fn cues(clusters: &[(u64, Vec<u8>)], first: u64) -> Vec<u8> {
    let mut place = first;
    let points = clusters.iter().flat_map(|(time, cluster)| {
        let at = element(0xb7, &[uint(0xf7, 1), uint(0xf1, place)].concat());
        place += cluster.len() as u64;
        element(0xbb, &[uint(0xb3, *time), at].concat())
    });
    let points: Vec<u8> = points.collect();
    element(0x1c53_bb6b, &points)
}
