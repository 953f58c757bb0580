//! Photos of phones, with the depth that the phone measured.

pub(crate) mod heic;
pub(crate) mod jpeg;
pub(crate) mod side_file;
