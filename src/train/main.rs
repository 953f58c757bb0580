//! `plenoscope-train`: trains, evaluates and exports Plenoscope's nets.

#![allow(clippy::print_stdout, reason = "a command line prints its results")]

use std::path::PathBuf;
use std::process::ExitCode;
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};

use anyhow::{Context as _, Result};
use clap::{ArgMatches, Args as _, Command, arg, value_parser};
use plenoscope::errors::sentence;
use plenoscope::kernel::blocks::LargeBlocks;
use plenoscope_train::checkpoint::{Checkpoint, Moments};
use plenoscope_train::config::{Config, Preset, Stage};
use plenoscope_train::export::{self, About, Bits};
use plenoscope_train::{bench, data, eval, paper, recorded, run, scenes};

#[global_allocator]
static BLOCKS: LargeBlocks = LargeBlocks::keeping(4 << 30);

fn main() -> ExitCode {
    let matches = command().get_matches();
    let done = match matches.subcommand() {
        Some(("train", matches)) => train(matches),
        Some(("export", matches)) => export(matches),
        Some(("bench", matches)) => bench(matches),
        Some(("eval", matches)) => eval::run(matches).map(|text| print!("{text}")),
        Some(("paper", matches)) => paper(matches),
        Some(("teach", matches)) => teach(matches),
        Some(("data", matches)) if matches.get_one::<PathBuf>("pack").is_some() => pack(matches),
        Some(("data", matches)) if matches.get_one::<PathBuf>("stats").is_some() => {
            recorded::stats::run(matches).map(|text| print!("{text}"))
        }
        Some(("data", matches)) => scenes::write::run(matches).map(|text| print!("{text}")),
        _ => Ok(()),
    };
    match done {
        Ok(()) => ExitCode::SUCCESS,
        Err(error) => {
            eprintln!("error: {}", sentence(&*error));
            ExitCode::FAILURE
        }
    }
}

fn command() -> Command {
    let resume = arg!(--resume <RUN> "Go on with the run in this folder; its config is the base")
        .required(false)
        .value_parser(value_parser!(PathBuf));
    let attended =
        arg!(--attended "Save and end when standard input ends: for a program that starts this one").required(false);
    let train = Config::augment_args(Command::new("train").about("Train a net, or go on with a run"));
    Command::new("plenoscope-train")
        .about("Trains, evaluates and exports Plenoscope's nets")
        .version(env!("CARGO_PKG_VERSION"))
        .subcommand_required(true)
        .subcommand(train.arg(resume).arg(attended))
        .subcommand(export_command())
        .subcommand(bench_command())
        .subcommand(eval::command())
        .subcommand(paper::command())
        .subcommand(scenes::write::command())
        .subcommand(scenes::teach::command())
}

fn export_command() -> Command {
    Command::new("export")
        .about("Write a checkpoint as models/<ID>/model.onnx with its manifest")
        .arg(
            arg!(<CHECKPOINT> ... "A .safetensors file of a run; of several, ends of runs that went on from one another, the mean; of a run between four corners both its files")
                .value_parser(value_parser!(PathBuf)),
        )
        .arg(arg!(--id <ID> "Name of the model and of its folder").required(true))
        .arg(arg!(--models <DIR> "Where models lie").value_parser(value_parser!(PathBuf)).default_value("models"))
        .arg(arg!(--licence <TEXT> "Licence of the weights").default_value("research use: see the model card"))
        .arg(
            arg!(--"training-data" <TEXT> "What it was trained on, comma-separated")
                .value_delimiter(',')
                .required(true),
        )
        .arg(arg!(--"long-side" <PX> "Working long side").value_parser(value_parser!(usize)).required(true))
        .arg(
            arg!(--gain <FACTOR> "Multiply the ray depths, for a working scale beside those that they were learned at")
                .value_parser(export::gain)
                .default_value("1"),
        )
        .arg(
            arg!(--bits <BITS> "What the weights are kept in: with 16 the file is half as large, with 8 a quarter")
                .value_parser(["32", "16", "8"])
                .default_value("32"),
        )
        .arg(
            arg!(--checkpoint <FILE> "Also save a small checkpoint, without moments, to start from")
                .required(false)
                .value_parser(value_parser!(PathBuf)),
        )
}

fn bench_command() -> Command {
    Config::augment_args(Command::new("bench").about("Time a step and its share of the machine's peak"))
        .arg(arg!(--json "One JSON object on stdout"))
}

fn train(matches: &ArgMatches) -> Result<()> {
    let resume = matches.get_one::<PathBuf>("resume");
    let base = resume.map(|folder| saved_config(folder)).transpose()?;
    let mut config = Config::from_matches(matches, base)?;
    if let Some(folder) = resume {
        config.out.clone_from(folder);
    }
    threads(&config)?;
    let stop = stop_on_interrupt()?;
    if matches.get_flag("attended") {
        stop_with_input(stop.clone())?;
    }
    let nets = match resume {
        Some(folder) => run::Nets::resume(&config, folder)?,
        None => run::Nets::start(&config)?,
    };
    if config.preset == Preset::Paper {
        run::train(&config, nets, &recorded::draw(&config, recorded::told())?, None, &stop)?;
        return Ok(());
    }
    let source = data::engine(&data::scenes_config(&config)?, &mut |note| eprintln!("{note}"))?;
    let watch = (config.stage == Stage::Depth).then(|| data::watch(&config, &source)).transpose()?;
    run::train(&config, nets, &data::draw(&config, &source), watch, &stop)?;
    Ok(())
}

/// Sets a flag once standard input ends: whoever started this program is gone, or wants it to end.
fn stop_with_input(stop: Arc<AtomicBool>) -> Result<()> {
    let listen = move || {
        // What is read says nothing; that it fails is an end, too.
        drop(std::io::copy(&mut std::io::stdin(), &mut std::io::sink()));
        stop.store(true, Ordering::Relaxed);
    };
    std::thread::Builder::new().name("input".into()).spawn(listen)?;
    Ok(())
}

/// Set by Ctrl-C.
fn stop_on_interrupt() -> Result<Arc<AtomicBool>> {
    let stop = Arc::new(AtomicBool::new(false));
    let flag = stop.clone();
    ctrlc::set_handler(move || flag.store(true, Ordering::Relaxed))?;
    Ok(stop)
}

fn pack(matches: &ArgMatches) -> Result<()> {
    let (from, to) = (required::<PathBuf>(matches, "pack")?, required::<PathBuf>(matches, "out")?);
    let told = |text: &str| eprintln!("{text}");
    let stop = stop_on_interrupt()?;
    print!("{}", recorded::packed::pack(&from, &to, &stop, &told)?);
    Ok(())
}

fn paper(matches: &ArgMatches) -> Result<()> {
    let asked = paper::Asked::from_matches(matches)?;
    pool(asked.threads)?;
    let stop = stop_on_interrupt()?;
    let told = |text: &str| eprintln!("{text}");
    let report = paper::run(&asked, &stop, &told)?;
    println!("{}", report.display());
    Ok(())
}

fn teach(matches: &ArgMatches) -> Result<()> {
    let stop = stop_on_interrupt()?;
    print!("{}", scenes::teach::run(matches, &stop, &|text| eprintln!("{text}"))?);
    Ok(())
}

/// The argument of a name that clap has made sure of.
fn required<T: Clone + Send + Sync + 'static>(matches: &ArgMatches, name: &str) -> Result<T> {
    matches.get_one::<T>(name).cloned().with_context(|| format!("{name} is missing"))
}

fn export(matches: &ArgMatches) -> Result<()> {
    let paths = matches.get_many::<PathBuf>("CHECKPOINT").into_iter().flatten();
    let nets = paths.map(|path| Checkpoint::load(path)).collect::<Result<Vec<_>, _>>()?;
    let (mut net, colour) = export::parted(nets)?;
    export::amplify(&mut net, required(matches, "gain")?)?;
    let about = About {
        id: required(matches, "id")?,
        licence: required(matches, "licence")?,
        training_data: matches.get_many::<String>("training-data").into_iter().flatten().cloned().collect(),
        working_long_side: required(matches, "long-side")?,
        bits: match required::<String>(matches, "bits")?.as_str() {
            "8" => Bits::Eight,
            "16" => Bits::Sixteen,
            _ => Bits::ThirtyTwo,
        },
    };
    let (folder, difference) = export::export(&net, colour.as_ref(), &about, &required::<PathBuf>(matches, "models")?)?;
    if let Some(path) = matches.get_one::<PathBuf>("checkpoint") {
        net.save(path, Moments::Without)?;
    }
    eprintln!("{} (differs from the trained net by at most {difference:.1e})", folder.display());
    Ok(())
}

fn bench(matches: &ArgMatches) -> Result<()> {
    let config = Config::from_matches(matches, None)?;
    threads(&config)?;
    let measured = bench::measure(&config)?;
    if matches.get_flag("json") {
        println!("{}", serde_json::json!({ "steps": measured }));
        return Ok(());
    }
    for m in measured {
        println!(
            "{}: {:.3} s, {:.1} GFLOP, {:.0} GFLOP/s = {:.0} % of {:.0} on {} threads",
            m.what,
            m.seconds,
            m.gflop,
            m.gflop / m.seconds,
            100.0 * m.share_of_peak,
            m.peak_gflops,
            m.threads
        );
    }
    Ok(())
}

fn threads(config: &Config) -> Result<()> {
    pool(config.threads)
}

fn pool(threads: usize) -> Result<()> {
    let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).thread_name(|i| format!("train-{i}"));
    // This thread is one of them: as a guest it would sleep and be woken at each of a step's hundreds of operations.
    let pool = pool.use_current_thread();
    Ok(pool.build_global()?)
}

fn saved_config(folder: &std::path::Path) -> Result<Config> {
    let path = folder.join(run::CONFIG_FILE);
    let text =
        std::fs::read_to_string(&path).with_context(|| format!("cannot read the run's config: {}", path.display()))?;
    serde_json::from_str(&text).with_context(|| format!("the run's config is damaged: {}", path.display()))
}
