//! Small valid files of every format, made by the program or by the libraries of the formats.

use crate::made_bags::{KIND, Made, joint_state, write, write_mcap};
use crate::made_mats::{compressed, doubles, mat_of};
use anyhow::{Context, Result};
use mcap::WriteOptions;
use ndarray::Array2;
use ndarray_npy::WriteNpyExt;
use std::fs;
use std::io::{Cursor, Write};
use std::iter;
use std::ops::ControlFlow;
use std::path::Path;
use torquewise::dynamics::plan::{MotionKind, MotionPlan};
use torquewise::dynamics::{Arm, simulate};
use torquewise::identify::plan::LibraryOptions;
use torquewise::identify::{Method, PatternPlan, Plan, summarise};
use torquewise::logs::TableWriter;
use torquewise::motion::Motion;
use torquewise::{Fit, FitOptions};
use zip::write::SimpleFileOptions;
use zip::{CompressionMethod, ZipWriter};

/// A seed in parts that are mutated on their own, where a checksum covers them or they are packed.
#[derive(Clone, Debug)]
pub struct Seed {
    /// Its parts.
    pub parts: Vec<Vec<u8>>,
    pack: fn(&[Vec<u8>]) -> Vec<u8>,
}

impl Seed {
    /// The bytes of the file.
    pub fn bytes(&self) -> Vec<u8> {
        (self.pack)(&self.parts)
    }

    /// As it stands in the file.
    fn whole(bytes: Vec<u8>) -> Self {
        Self { parts: vec![bytes], pack: <[Vec<u8>]>::concat }
    }
}

/// The arrays of a log, in the order of their parts.
const ARRAYS: [&str; 5] = ["t", "q", "dq", "ddq", "tau"];

/// A zip archive of arrays.
fn zipped(members: &[Vec<u8>]) -> Vec<u8> {
    let archive = || -> Result<Vec<u8>> {
        let mut archive = ZipWriter::new(Cursor::new(Vec::new()));
        let methods = [CompressionMethod::Stored, CompressionMethod::Deflated].into_iter().cycle();
        for ((name, bytes), method) in ARRAYS.iter().zip(members).zip(methods) {
            let options = SimpleFileOptions::default().compression_method(method);
            archive.start_file(format!("{name}.npy"), options)?;
            archive.write_all(bytes)?;
        }
        Ok(archive.finish()?.into_inner())
    };
    archive().unwrap_or_default()
}

/// A header of 12 bytes, the checksum of the rest, and the rest.
fn framed(parts: &[Vec<u8>]) -> Vec<u8> {
    let (mut header, body) = (parts[0].clone(), parts[1..].concat());
    header.resize(16, 0);
    header[12..].copy_from_slice(&crc32fast::hash(&body).to_le_bytes());
    [header, body].concat()
}

/// The header of a MAT file and its elements, each of which is compressed.
fn packed(parts: &[Vec<u8>]) -> Vec<u8> {
    parts[1..].iter().fold(parts[0].clone(), |bytes, element| [bytes, compressed(element)].concat())
}

/// The seeds of a reader, the same every time.
///
/// # Errors
/// Those of making them.
#[expect(clippy::too_many_lines, reason = "one reader after the other")]
pub fn seeds(reader: &str) -> Result<Vec<Seed>> {
    let folder = tempfile::tempdir()?;
    let file = folder.path().join(format!("log.{reader}"));
    let array_columns = |name: &str| if name == "t" { 1 } else { 2 };
    Ok(match reader {
        "csv" | "parquet" => {
            let mut writer = TableWriter::log(&file, motion(40)?.joints(), true)?;
            writer.append_motion(&motion(40)?)?;
            writer.finish()?;
            vec![Seed::whole(fs::read(file)?)]
        }
        "db3" | "mcap" => {
            let topics = [("/joint_states", KIND), ("/other", "std_msgs/msg/String")];
            write(&file, &topics, &messages());
            let mut found = vec![Seed::whole(fs::read(&file)?)];
            if reader == "mcap" {
                // Without checksums, what lies behind them is reached.
                let open = WriteOptions::default()
                    .compression(None)
                    .calculate_chunk_crcs(false)
                    .calculate_data_section_crc(false)
                    .calculate_summary_section_crc(false)
                    .calculate_attachment_crcs(false);
                write_mcap(&file, &topics, &messages(), open);
                found.push(Seed::whole(fs::read(&file)?));
            }
            found
        }
        "npz" => {
            let npy = |name| {
                let mut bytes = Vec::new();
                array(array_columns(name)).write_npy(&mut bytes).map(|()| bytes)
            };
            let parts = ARRAYS.into_iter().map(npy).collect::<Result<_, _>>()?;
            let seed = Seed { parts, pack: zipped };
            vec![Seed::whole(seed.bytes()), seed]
        }
        "mat" => {
            let elements = ARRAYS.map(|name| doubles(name, &array(array_columns(name))));
            let parts: Vec<Vec<u8>> = iter::once(mat_of(&[])).chain(elements).collect();
            vec![Seed::whole(parts.concat()), Seed { parts, pack: packed }]
        }
        "model" => {
            let chain = FitOptions {
                library: Some(torquewise::Library::Chain),
                friction: Some(torquewise::FrictionKind::Auto),
                ..FitOptions::default()
            };
            let log = motion(400)?;
            let model = |options| -> Result<Seed> {
                let model = Fit::new(&log).options(options).run()?.model.clone();
                Ok(Seed::whole(torquewise::model::file::to_json(&model)?.into_bytes()))
            };
            vec![model(FitOptions::default())?, model(chain)?]
        }
        "moments" => {
            let method = Method::Library(LibraryOptions::default());
            let plan = Plan { method, patterns: PatternPlan::default(), seed: 0 };
            let bytes =
                summarise(&motion(400)?, &plan, "", &|_| ControlFlow::Continue(()))?.to_bytes()?;
            let (header, body) = bytes.split_at(16);
            vec![Seed { parts: vec![header.to_vec(), body.to_vec()], pack: framed }]
        }
        "profile" => ["kuka_kr300", "tiago_arm", "ur10"]
            .iter()
            .map(|name| text(&format!("profiles/{name}.toml")))
            .collect::<Result<_>>()?,
        "dh" => vec![text("crates/torquewise-sim/src/arms/planar-2.toml")?],
        "friction" => vec![Seed::whole(include_str!("friction.toml").into())],
        _ => vec![text("examples/three-joint.urdf")?],
    })
}

/// A file of the repository.
fn text(path: &str) -> Result<Seed> {
    let file = Path::new(env!("CARGO_MANIFEST_DIR")).join("..").join(path);
    Ok(Seed::whole(fs::read(&file).with_context(|| format!("no {}", file.display()))?))
}

fn motion(rows: u32) -> Result<Motion> {
    let arm = Arm::builtin("planar-2")?;
    let kind = MotionKind::Sines;
    let plan = MotionPlan { kind, seconds: f64::from(rows) / 50.0, rate: 50.0, seed: 1 };
    Ok(simulate(&arm, &plan)?.motion)
}

fn messages() -> Vec<Made> {
    let state = |row: i32| {
        let at = f64::from(row);
        let signals = [&[at, -at][..], &[1.0, 0.5], &[0.1 * at, 2.0]];
        let received = 10_000_000 * i64::from(row);
        let bytes = joint_state(received, &["shoulder", "elbow"], signals);
        Made { topic: "/joint_states", received, bytes }
    };
    (1..40).map(state).collect()
}

/// An array of as many rows as a log of arrays has.
fn array(columns: usize) -> Array2<f64> {
    Array2::from_shape_fn((30, columns), |(row, column)| 0.01 * (row * columns + column) as f64)
}
