//! What a picture of this program says of how it was made: its recipe, and the photo that it was made of.
//!
//! It may come from a stranger. Here it is only text, a name and bytes; who uses it checks the recipe as any other, takes
//! the name for one of a file right beside the picture, and the bytes for a photo only where they have the hash.

use std::sync::Arc;

use serde::Serialize;
use sha2::{Digest, Sha256};

use super::xmp::Xmp;
use crate::within;

/// The namespace of this program's properties.
pub(crate) const NAMESPACE: &str = "urn:plenoscope:picture:1.0/";
/// The version of these properties.
pub(crate) const VERSION: u32 = 1;
pub(crate) const RECIPE: &str = "Recipe";
pub(crate) const PHOTO: &str = "Photo";
pub(crate) const PHOTO_NAME: &str = "PhotoName";
pub(crate) const PHOTO_SHA256: &str = "PhotoSha256";
pub(crate) const PHOTO_BYTES: &str = "PhotoBytes";

/// Which photo a picture was made of.
#[derive(Clone, Debug, PartialEq, Eq, Serialize)]
pub struct PhotoTag {
    /// Its file's name.
    pub name: String,
    /// Its file's checksum, 64 digits.
    pub sha256: String,
    /// Its file's length.
    pub bytes: u64,
}

impl PhotoTag {
    /// The tag of a file.
    pub fn of(name: &str, file: &[u8]) -> Self {
        Self { name: name.to_owned(), sha256: hash(file), bytes: file.len() as u64 }
    }

    /// Whether a file is this one.
    pub fn is_of(&self, file: &[u8]) -> bool {
        file.len() as u64 == self.bytes && hash(file) == self.sha256
    }
}

fn hash(file: &[u8]) -> String {
    Sha256::digest(file).iter().map(|byte| format!("{byte:02x}")).collect()
}

/// What was found in a picture.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Carried {
    /// The recipe, JSON that nobody has checked.
    pub recipe: String,
    /// The photo that it was made of, where it says one.
    pub photo: Option<PhotoTag>,
    /// That photo's file, where it lies in the picture.
    pub file: Option<Arc<[u8]>>,
}

/// Whether a packet is worth a look.
pub(crate) fn is_told_of(packet: &[u8]) -> bool {
    packet.windows(NAMESPACE.len()).any(|window| window == NAMESPACE.as_bytes())
}

/// What a packet that is no XMP any more has carried: nothing that can be used, but not nothing.
pub(crate) fn find_damaged(packet: &[u8]) -> Option<Result<Carried, String>> {
    is_told_of(packet).then(|| Xmp::parse(packet).err()).flatten().map(Err)
}

/// Looks for it in a picture's XMP.
///
/// # Errors
/// What is there cannot be used; why, as the middle of a sentence.
pub(crate) fn find(main: &Xmp, extended: Option<&Result<Xmp, String>>) -> Option<Result<Carried, String>> {
    main.get(NAMESPACE, "Version").map(|version| {
        if version.parse() != Ok(VERSION) {
            return Err("it was written by a later version of the program".to_owned());
        }
        let behind = match extended {
            Some(Err(why)) => return Err(why.clone()),
            Some(Ok(extended)) => Some(extended),
            None => None,
        };
        let all = || std::iter::once(main).chain(behind);
        let recipe = all().find_map(|xmp| xmp.get(NAMESPACE, RECIPE)).ok_or("its recipe is missing")?.to_owned();
        let file = all().find_map(|xmp| xmp.base64(NAMESPACE, PHOTO)).transpose()?.map(Arc::from);
        let photo = tag(main)?;
        match (&photo, &file) {
            (Some(tag), Some(file)) if !tag.is_of(file) => Err("the photo in it is damaged".to_owned()),
            (None, Some(_)) => Err("nothing says which photo is in it".to_owned()),
            _ => Ok(Carried { recipe, photo, file }),
        }
    })
}

/// The photo's tag, if there is one: a plain name, so that it leads nowhere else.
fn tag(xmp: &Xmp) -> Result<Option<PhotoTag>, String> {
    let text = |name| xmp.get(NAMESPACE, name);
    let Some(name) = text(PHOTO_NAME) else { return Ok(None) };
    let sha256 = text(PHOTO_SHA256).filter(|hash| hash.len() == 64 && hash.bytes().all(|c| c.is_ascii_hexdigit()));
    let bytes = text(PHOTO_BYTES).and_then(|bytes| bytes.parse().ok());
    match (within::is_plain_name(name), sha256, bytes) {
        (true, Some(sha256), Some(bytes)) => {
            Ok(Some(PhotoTag { name: name.to_owned(), sha256: sha256.to_ascii_lowercase(), bytes }))
        }
        (false, ..) => Err("its photo's name is no plain file name".to_owned()),
        _ => Err("it does not say which photo it was made of".to_owned()),
    }
}

impl Carried {
    /// What is in it, for people.
    pub(crate) fn told(&self) -> String {
        let of = self.photo.as_ref().map(|tag| within::plain_words(&tag.name, 80));
        match (of, &self.file) {
            (Some(name), Some(_)) => format!("the edit, and its photo {name}"),
            (Some(name), None) => format!("the edit of {name}"),
            (None, _) => "the edit".to_owned(),
        }
    }
}
