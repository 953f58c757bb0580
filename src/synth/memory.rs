//! Whether a light field fits in memory, asked before it is begun.

use std::fs;

use super::SynthError;
use crate::field::ViewGrid;

/// Bytes a view pixel takes at the peak: its ray depth, Lambertian and corrected colours, residual.
const BYTES_PER_RAY: u64 = 4 + 4 + 4 + 6;
/// What the nets take besides, whatever the size.
const NETS_BYTES: u64 = 450 << 20;

/// Refuses a light field that does not fit, and says which size would.
pub(super) fn check(size: [u32; 2], grid: ViewGrid) -> Result<(), SynthError> {
    free_bytes().map_or(Ok(()), |free| check_against(size, grid, free))
}

fn check_against(size: [u32; 2], grid: ViewGrid, free_bytes: u64) -> Result<(), SynthError> {
    let rays = u64::from(size[0]) * u64::from(size[1]) * grid.count() as u64;
    let need_bytes = NETS_BYTES + rays * BYTES_PER_RAY;
    if need_bytes <= free_bytes {
        return Ok(());
    }
    let room = free_bytes.saturating_sub(NETS_BYTES) as f64 / (rays * BYTES_PER_RAY) as f64;
    let fits = (f64::from(size[0].max(size[1])) * room.sqrt()) as u32;
    Err(SynthError::OutOfMemory { need_bytes, free_bytes, fits: fits.max(1) })
}

/// Memory that can be had without swapping; none where the system does not say.
pub fn free_bytes() -> Option<u64> {
    let text = fs::read_to_string("/proc/meminfo").ok()?;
    let line = text.lines().find(|line| line.starts_with("MemAvailable:"))?;
    let kib: u64 = line.split_whitespace().nth(1)?.parse().ok()?;
    Some(kib << 10)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_light_field_that_does_not_fit_names_a_size_that_does() {
        let free = 1 << 30;
        let Err(SynthError::OutOfMemory { fits, .. }) = check_against([4000, 3000], ViewGrid::PAPER, free) else {
            panic!("12 million pixels by 64 views do not fit in 1 GiB");
        };
        assert!(check_against([fits, fits * 3 / 4], ViewGrid::PAPER, free).is_ok(), "{fits} should fit");
        assert!(check_against([fits * 2, fits * 3 / 2], ViewGrid::PAPER, free).is_err());
    }
}
