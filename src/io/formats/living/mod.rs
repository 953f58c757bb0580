//! The living picture: one HTML file that is refocused and looked into wherever it is opened, without a connection.
//!
//! The photo and what is behind its edges travel as JPEG, disparities as PNG, all as `data:` addresses. A script of this
//! program's, the only one that the page's policy lets run, does in WebGL2 what the lens renderer does (`page/draw.js`),
//! slice by slice; while something moves, a draft gathers discs in one pass. Where there is no WebGL2, a strip of pictures
//! is shown.

use std::fmt::Write as _;
use std::io::Write as _;
use std::path::Path;

use base64::Engine;
use base64::engine::general_purpose::STANDARD;
use jpeg_encoder::{ColorType as JpegColor, Encoder, SamplingFactor};
use png::{BitDepth, ColorType, Compression};
use serde::Serialize;
use sha2::{Digest, Sha256};

use super::out;
use crate::field::Size;
use crate::io::save::SaveError;
use crate::markup::escaped;

const PAGE: &str = include_str!("page/page.html");
const STYLE: &str = include_str!("page/page.css");
const SCRIPT: [&str; 2] = [include_str!("page/draw.js"), include_str!("page/page.js")];

/// The page is not to be larger than this: it goes by mail.
pub const MOST_BYTES: usize = 3_000_000;
/// Qualities of the photo that are tried, from the best on.
const QUALITIES: [u8; 5] = [92, 86, 80, 72, 60];
/// Of the colours behind edges, which are blurred by nature, and of the strip.
const OTHER_QUALITY: u8 = 80;

/// A picture that lives.
pub struct Living {
    /// What it is called.
    pub title: String,
    /// The photo, sRGB.
    pub photo: Rgb,
    /// Near disparity, near minus far disparity, and what the near side leaves free, of each pixel: 253 to 255 is all of it,
    /// 255 where it has left no stain either.
    pub depths: Rgb,
    /// Colours behind the edges, sRGB.
    pub behind: Rgb,
    /// Disparity, share, and cells from the edge, of what is behind.
    pub behind_depths: Rgb,
    /// All that the script has to know.
    pub scene: Numbers,
    /// Pictures for those who cannot do more, and what they are.
    pub strip: Vec<(String, Rgb)>,
}

/// Three bytes a pixel, `[y, x]`.
pub struct Rgb {
    /// Width and height.
    pub size: Size,
    /// The pixels.
    pub pixels: Vec<[u8; 3]>,
}

/// The numbers of a scene and of the lens that it begins with. Disparities are in pixels of the map's width.
#[derive(Clone, Debug, Serialize)]
#[serde(rename_all = "camelCase")]
pub struct Numbers {
    /// Width and height of the photo.
    pub size: Size,
    /// Width and height of what is behind.
    pub behind_size: Size,
    /// Disparity of byte 0 and of byte 255.
    pub range: [f32; 2],
    /// Pixels of the photo per pixel of the map.
    pub scale: f32,
    /// View steps that the eye may go to either side.
    pub reach: f32,
    /// The lens at first.
    pub f_number: f32,
    /// Its sharp disparity in the middle.
    pub focus: f32,
    /// Growth of that to the right and down.
    pub tilt: [f32; 2],
    /// By how much the sharp surface is nearer in the corners.
    pub curve: f32,
    /// What stays sharp beside it.
    pub keep_sharp: [f32; 2],
    /// How much clipped lights are brightened.
    pub highlights: f32,
    /// Where the eye is at first.
    pub eye: [f32; 2],
    /// The disparity that stays where it is while the eye goes round.
    pub pivot: f32,
}

/// Writes the page. The photo's quality goes down until the page is small enough.
///
/// # Errors
/// [`SaveError`]; then nothing has been written.
pub fn write(path: &Path, living: &Living) -> Result<(), SaveError> {
    let page = page(living).map_err(|why| SaveError::Encode { why, path: path.to_owned() })?;
    out::single(path, |out| out.write_all(page.as_bytes()))
}

fn page(living: &Living) -> Result<String, String> {
    let mut page = String::new();
    for quality in QUALITIES {
        page = with_quality(living, quality)?;
        if page.len() <= MOST_BYTES {
            break;
        }
    }
    Ok(page)
}

fn with_quality(living: &Living, quality: u8) -> Result<String, String> {
    let script = SCRIPT.concat();
    let scene = serde_json::to_string(&living.scene).map_err(|e| e.to_string())?;
    let hash = |text: &str| STANDARD.encode(Sha256::digest(text.as_bytes()));
    let title = escaped(&living.title);
    let parts = [
        ("style-hash", hash(STYLE)),
        ("script-hash", hash(&script)),
        ("version", env!("CARGO_PKG_VERSION").to_owned()),
        ("title", title),
        ("style", STYLE.to_owned()),
        ("strip", strip(living)?),
        ("colors", jpeg(&living.photo, quality)?),
        ("depths", png(&living.depths)?),
        ("behind-colors", jpeg(&living.behind, OTHER_QUALITY)?),
        ("behind-depths", png(&living.behind_depths)?),
        // Within a script element `<` could end it.
        ("scene", scene.replace('<', "\\u003c")),
        ("script", script),
    ];
    Ok(filled(PAGE, &parts))
}

/// The template with its `{{name}}` filled in, each in one pass: what is filled in is not looked at again.
fn filled(template: &str, parts: &[(&str, String)]) -> String {
    let mut page = String::new();
    let mut rest = template;
    while let Some((before, from)) = rest.split_once("{{") {
        let (name, after) = from.split_once("}}").unwrap_or((from, ""));
        page.push_str(before);
        page.extend(parts.iter().find(|(part, _)| *part == name).map(|(_, text)| text.as_str()));
        rest = after;
    }
    page + rest
}

fn strip(living: &Living) -> Result<String, String> {
    let mut strip = String::new();
    for (name, picture) in &living.strip {
        let (name, data) = (escaped(name), jpeg(picture, OTHER_QUALITY)?);
        let _ = writeln!(
            strip,
            "<figure role=\"listitem\"><img src=\"{data}\" alt=\"{name}\"><figcaption>{name}</figcaption></figure>"
        );
    }
    Ok(strip)
}

fn jpeg(picture: &Rgb, quality: u8) -> Result<String, String> {
    let [width, height] = picture.size.map(|side| u16::try_from(side).unwrap_or(u16::MAX));
    let mut bytes = Vec::new();
    let mut encoder = Encoder::new(&mut bytes, quality);
    encoder.set_sampling_factor(if quality > 85 { SamplingFactor::F_1_1 } else { SamplingFactor::F_2_2 });
    encoder.set_optimized_huffman_tables(true);
    encoder.encode(picture.pixels.as_flattened(), width, height, JpegColor::Rgb).map_err(|e| e.to_string())?;
    Ok(data("jpeg", &bytes))
}

fn png(picture: &Rgb) -> Result<String, String> {
    let mut bytes = Vec::new();
    let [width, height] = picture.size;
    let mut encoder = png::Encoder::new(&mut bytes, width, height);
    encoder.set_color(ColorType::Rgb);
    encoder.set_depth(BitDepth::Eight);
    encoder.set_compression(Compression::High);
    let mut writer = encoder.write_header().map_err(|e| e.to_string())?;
    writer.write_image_data(picture.pixels.as_flattened()).map_err(|e| e.to_string())?;
    writer.finish().map_err(|e| e.to_string())?;
    Ok(data("png", &bytes))
}

fn data(kind: &str, bytes: &[u8]) -> String {
    format!("data:image/{kind};base64,{}", STANDARD.encode(bytes))
}

#[cfg(test)]
pub(super) mod tests {
    use super::*;

    /// A small picture of that name.
    pub(in crate::io::formats) fn living(title: &str) -> Living {
        let picture = |size: Size| {
            let pixels = (0..size[0] * size[1]).map(|i| [(i * 37 % 251) as u8, (i * 91 % 241) as u8, (i % 239) as u8]);
            Rgb { size, pixels: pixels.collect() }
        };
        let [size, behind_size] = [[64, 48], [32, 24]];
        let scene = Numbers {
            size,
            behind_size,
            range: [-1.0, 1.0],
            scale: 1.0,
            reach: 4.0,
            f_number: 2.0,
            focus: 0.0,
            tilt: [0.0; 2],
            curve: 0.0,
            keep_sharp: [0.0; 2],
            highlights: 0.0,
            eye: [0.0; 2],
            pivot: 0.0,
        };
        let strip = vec![(title.to_owned(), picture([8, 6]))];
        let [photo, depths] = [picture(size), picture(size)];
        let [behind, behind_depths] = [picture(behind_size), picture(behind_size)];
        Living { title: title.to_owned(), photo, depths, behind, behind_depths, scene, strip }
    }

    #[test]
    fn a_hostile_name_stays_text() {
        let page = page(&living("</title><script>alert(1)</script>\"'{{script}}&")).unwrap();
        assert!(page.contains("&lt;/title&gt;&lt;script&gt;alert(1)&lt;/script&gt;&quot;&#39;{{script}}&amp;"));
        assert_eq!(page.matches("<script").count(), 2, "the numbers, and our script");
    }

    #[test]
    fn nothing_is_asked_of_anyone_and_only_our_script_may_run() {
        let page = page(&living("rose")).unwrap();
        assert!(page.contains("default-src 'none'; img-src data:;"));
        let within = |open: &str, close: &str| page.split_once(open).unwrap().1.split_once(close).unwrap().0;
        for (name, text) in
            [("script-src", within("<script>", "</script>")), ("style-src", within("<style>", "</style>"))]
        {
            let hash = STANDARD.encode(Sha256::digest(text.as_bytes()));
            assert!(page.contains(&format!("{name} 'sha256-{hash}'")), "{name}");
        }
        assert!(page.split("src=\"").skip(1).all(|src| src.starts_with("data:image/")));
        assert!(!page.contains("://") && !page.contains("{{"), "no address, and nothing left to be filled in");
    }

    #[test]
    fn the_quality_goes_down_until_a_page_is_small() {
        let sizes: Vec<_> =
            QUALITIES.iter().map(|&quality| with_quality(&living("rose"), quality).unwrap().len()).collect();
        assert!(sizes.is_sorted_by(|a, b| a > b), "{sizes:?}");
    }
}
