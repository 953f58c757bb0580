//! Views, epipolar slices and maps of a scene, as they were asked for.

use super::Usage;
use crate::field::{DisparityMap, EpiLine, Picture, ViewGrid, ViewIndex, ViewOffset, ViewPoint};
use crate::job::Job;
use crate::render::cpu;
use crate::scene::{Need, Scene, SceneError};

/// What an eye between the views sees, in linear sRGB light. Beyond the views their edge is what is seen; the person is
/// told.
///
/// # Errors
/// [`SceneError::NoViews`] of a scene without them.
pub fn view(scene: &Scene, wanted: ViewOffset, job: &Job) -> Result<Picture, SceneError> {
    let views = scene.made_views()?;
    let inside = views.field.grid().clamp(wanted);
    if inside != wanted {
        job.sink.warning(format!("the views end at {},{}: that is what is shown", inside.du, inside.dv));
    }
    Ok(cpu::view_with_depths(&views.field, Some(&views.depths), ViewPoint(inside)))
}

/// A line of the views that an epipolar slice goes through.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Line {
    /// A row, cut in the reference view's row of views.
    Row(u32),
    /// A column, cut in the reference view's column of views.
    Column(u32),
}

impl Line {
    /// The one line of a row and a column that was named.
    ///
    /// # Errors
    /// None or both.
    pub fn one_of(row: Option<u32>, column: Option<u32>) -> Result<Self, Usage> {
        match (row, column) {
            (Some(y), None) => Ok(Self::Row(y)),
            (None, Some(x)) => Ok(Self::Column(x)),
            (None, None) => Err(Usage("a line is missing — give a row or a column".to_owned())),
            (Some(_), Some(_)) => Err(Usage("a row and a column were given — leave one of them out".to_owned())),
        }
    }
}

/// An epipolar slice, the views downwards, `scale` rows each, in linear sRGB light.
///
/// # Errors
/// [`SceneError::NoViews`] of a scene without them; a line outside the views.
pub fn epi(scene: &Scene, line: Line, scale: u32) -> Result<Picture, SceneError> {
    let field = &scene.made_views()?.field;
    let reference = field.grid().reference();
    let [width, height] = field.size();
    Ok(match line {
        Line::Row(y) => {
            inside("row", y, height)?;
            cpu::epi(field, EpiLine::Row { y, v: reference.v }, scale)
        }
        Line::Column(x) => {
            inside("column", x, width)?;
            transposed(&cpu::epi(field, EpiLine::Column { x, u: reference.u }, scale))
        }
    })
}

fn inside(what: &str, at: u32, end: u32) -> Result<(), Usage> {
    if at < end {
        return Ok(());
    }
    Err(Usage(format!("there is no {what} {at} — a view has {end} — name one from 0 to {}", end - 1)))
}

/// Rows become columns: the window shows a column's slice beside the picture, a file has the views downwards.
fn transposed(picture: &Picture) -> Picture {
    let [width, height] = picture.size;
    Picture::from_fn([height, width], |x, y| picture.pixel(y, x))
}

/// What must be made for the view from a place of the lens.
pub fn view_need(wanted: ViewOffset) -> Need {
    Need::Some(ViewGrid::PAPER.around(wanted))
}

/// What must be made for an epipolar slice.
pub fn epi_need(line: Line) -> Need {
    let (grid, middle) = (ViewGrid::PAPER, ViewGrid::PAPER.reference());
    Need::Some(match line {
        Line::Row(_) => grid.row(middle.v),
        Line::Column(_) => grid.column(middle.u),
    })
}

/// What must be made for the map of a view; that of the reference view alone needs no others.
pub fn depth_need(view: Option<[f32; 2]>) -> Need {
    let Some(at) = view else { return Need::Map };
    // Which views a recorded light field has is not known here: no such view is an error later.
    view_index(ViewGrid::PAPER, at).map_or(Need::Views, |at| Need::Some(at.into()))
}

/// The map of a view, row and column; that of the reference view as exact as it is known.
///
/// # Errors
/// No such view.
pub fn depth(scene: &Scene, view: Option<[f32; 2]>) -> Result<DisparityMap, SceneError> {
    match (view, scene.views()) {
        (Some(at), Some(views)) => Ok(views.depths.map(view_index(views.depths.grid(), at)?)),
        _ => Ok(DisparityMap::clone(scene.map())),
    }
}

/// The view of a row and a column.
///
/// # Errors
/// No such view.
pub fn view_index(grid: ViewGrid, [v, u]: [f32; 2]) -> Result<ViewIndex, Usage> {
    let whole = |n: f32, end: usize| n.fract() == 0.0 && (0.0..end as f32).contains(&n);
    if !(whole(v, grid.rows()) && whole(u, grid.cols())) {
        let (rows, cols) = (grid.rows() - 1, grid.cols() - 1);
        return Err(Usage(format!("there is no view {v},{u} — views go from 0,0 to {rows},{cols} — name one of them")));
    }
    Ok(ViewIndex { v: v as u8, u: u as u8 })
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::render::aperture::nearest_views;

    #[test]
    fn all_views_that_an_eye_between_them_takes_are_made() {
        let grid = ViewGrid::PAPER;
        for (dv, du) in [(0.0, 0.0), (0.5, -1.0), (-3.999, 2.001), (-9.0, 9.0), (3.0, -4.0), (2.25, 0.75)] {
            let wanted = ViewOffset { dv, du };
            let Need::Some(block) = view_need(wanted) else { panic!("some views") };
            let taps = nearest_views(grid, ViewPoint(grid.clamp(wanted)), |_| true);
            assert!(taps.iter().all(|tap| block.contains(tap.view)), "{dv} {du}: {block:?}");
        }
    }
}
