//! Opens the window on the files that are named.

fn main() -> Result<(), plenoscope::ui::WindowError> {
    let files = std::env::args().skip(1).map(Into::into).collect();
    plenoscope::ui::run(plenoscope::ui::Options {
        files,
        models: plenoscope::synth::ModelSource::Embedded,
        long_side: None,
        threads: 0,
        restores_last: false,
    })
}
