//! Small valid files of every format, made by the program or by the libraries of the formats.

use crate::made_bags::{KIND, Made, joint_state, write, write_mcap};
use crate::reader::Reader;
use anyhow::{Context, Result};
use flate2::Compression;
use flate2::write::ZlibEncoder;
use mcap::WriteOptions;
use std::fs;
use std::io::{Cursor, Write};
use std::path::Path;
use torquewise::dynamics::plan::{MotionKind, MotionPlan};
use torquewise::dynamics::{Arm, simulate};
use torquewise::identify::plan::LibraryOptions;
use torquewise::identify::{Method, PatternPlan, Plan, summarise};
use torquewise::logs::{Contents, LogWriter};
use torquewise::motion::Motion;
use torquewise::{Fit, FitOptions};
use zip::write::SimpleFileOptions;
use zip::{CompressionMethod, ZipWriter};

/// A seed in parts that are mutated on their own, where a checksum covers them.
#[derive(Clone, Debug)]
pub enum Seed {
    /// As it stands in the file.
    Whole(Vec<u8>),
    /// Members of a zip archive.
    Zip(Vec<(String, Vec<u8>)>),
    /// A header of 20 bytes, the checksum of the rest, and the rest.
    Framed(Vec<u8>),
    /// The header of a MAT file and its elements, each of which is compressed.
    Mat(Vec<u8>, Vec<Vec<u8>>),
}

impl Seed {
    /// The bytes of the file.
    pub fn bytes(&self) -> Vec<u8> {
        match self {
            Self::Whole(bytes) => bytes.clone(),
            Self::Zip(members) => zipped(members).unwrap_or_default(),
            Self::Framed(bytes) => {
                let mut bytes = bytes.clone();
                if let Some((header, body)) = bytes.split_at_mut_checked(24) {
                    header[12..20].copy_from_slice(&(body.len() as u64).to_le_bytes());
                    header[20..].copy_from_slice(&crc32fast::hash(body).to_le_bytes());
                }
                bytes
            }
            Self::Mat(header, elements) => {
                let mut bytes = header.clone();
                for element in elements {
                    let mut packed = ZlibEncoder::new(Vec::new(), Compression::fast());
                    let packed = packed.write_all(element).and_then(|()| packed.finish());
                    let packed = packed.unwrap_or_default();
                    bytes.extend(15_u32.to_le_bytes());
                    bytes.extend(u32::try_from(packed.len()).unwrap_or(u32::MAX).to_le_bytes());
                    bytes.extend(packed);
                }
                bytes
            }
        }
    }
}

fn zipped(members: &[(String, Vec<u8>)]) -> Result<Vec<u8>> {
    let mut archive = ZipWriter::new(Cursor::new(Vec::new()));
    for (place, (name, bytes)) in members.iter().enumerate() {
        let method =
            if place % 2 == 0 { CompressionMethod::Stored } else { CompressionMethod::Deflated };
        let options = SimpleFileOptions::default().compression_method(method);
        archive.start_file(name.as_str(), options)?;
        archive.write_all(bytes)?;
    }
    Ok(archive.finish()?.into_inner())
}

/// The seeds of a reader, the same every time.
///
/// # Errors
/// Those of making them.
pub fn seeds(reader: Reader) -> Result<Vec<Seed>> {
    match reader {
        Reader::Csv | Reader::Parquet | Reader::Db3 | Reader::Mcap | Reader::Npz | Reader::Mat => {
            of_log(reader)
        }
        _ => of_text(reader),
    }
}

fn of_log(reader: Reader) -> Result<Vec<Seed>> {
    let folder = tempfile::tempdir()?;
    Ok(match reader {
        Reader::Csv | Reader::Parquet => {
            let file = folder.path().join(format!("log.{}", reader.name()));
            let mut writer = LogWriter::create(&file, motion(40)?.joints(), Contents::default())?;
            writer.append(&motion(40)?)?;
            writer.finish()?;
            vec![Seed::Whole(fs::read(file)?)]
        }
        Reader::Db3 | Reader::Mcap => {
            let file = folder.path().join(format!("bag.{}", reader.name()));
            let topics = [("/joint_states", KIND), ("/other", "std_msgs/msg/String")];
            write(&file, &topics, &messages());
            let mut found = vec![Seed::Whole(fs::read(&file)?)];
            if reader == Reader::Mcap {
                // Without checksums, what lies behind them is reached.
                let open = WriteOptions::default()
                    .compression(None)
                    .calculate_chunk_crcs(false)
                    .calculate_data_section_crc(false)
                    .calculate_summary_section_crc(false)
                    .calculate_attachment_crcs(false);
                write_mcap(&file, &topics, &messages(), open);
                found.push(Seed::Whole(fs::read(&file)?));
            }
            found
        }
        Reader::Npz => {
            let array =
                |name: &str| (format!("{name}.npy"), npy(30, if name == "t" { 1 } else { 2 }));
            let seed = Seed::Zip(["t", "q", "dq", "ddq", "tau"].map(array).to_vec());
            vec![Seed::Whole(seed.bytes()), seed]
        }
        Reader::Mat => {
            let element = |name: &str| matrix(name, 30, if name == "t" { 1 } else { 2 });
            let elements = ["t", "q", "dq", "ddq", "tau"].map(element);
            let mut header = format!("{:<116}", "MATLAB 5.0 MAT-file").into_bytes();
            header.extend([0; 8]);
            header.extend([0, 1]);
            header.extend(b"IM");
            let plain = Seed::Whole([header.clone(), elements.concat()].concat());
            vec![plain, Seed::Mat(header, elements.to_vec())]
        }
        _ => Vec::new(),
    })
}

fn of_text(reader: Reader) -> Result<Vec<Seed>> {
    let root = Path::new(env!("CARGO_MANIFEST_DIR")).join("..");
    let text = |path: &str| -> Result<Seed> {
        let file = root.join(path);
        Ok(Seed::Whole(fs::read(&file).with_context(|| format!("no {}", file.display()))?))
    };
    let literal = |text: &str| Seed::Whole(text.as_bytes().to_vec());
    Ok(match reader {
        Reader::Model => {
            let log = motion(400)?;
            let model = |options| -> Result<Seed> {
                let model = Fit::new(&log).options(options).run()?.model.clone();
                Ok(Seed::Whole(torquewise::model::file::to_json(&model)?.into_bytes()))
            };
            let chain = FitOptions {
                library: Some(torquewise::Library::Chain),
                friction: Some(torquewise::FrictionKind::Auto),
                ..FitOptions::default()
            };
            vec![model(FitOptions::default())?, model(chain)?]
        }
        Reader::Moments => {
            let method = Method::Library(LibraryOptions::default());
            let plan = Plan { method, patterns: PatternPlan::default(), seed: 0 };
            let summary = summarise(&motion(400)?, &plan, "", &mut |_| ())?;
            vec![Seed::Framed(summary.to_bytes()?)]
        }
        Reader::Profile => vec![
            text("profiles/kuka_kr300.toml")?,
            text("profiles/tiago_arm.toml")?,
            text("profiles/ur10.toml")?,
        ],
        Reader::Dh => vec![text("crates/torquewise-sim/src/arms/planar-2.toml")?],
        Reader::Friction => vec![literal(
            "width = 0.01\n[joint1]\ncoulomb = 4.0\nstiction = 6.0\nspeed = 0.1\nviscous = 2.0\n\
             backward = { coulomb = 3.0, stiction = 4.0, speed = 0.1, viscous = 1.0 }\n[joint2]\ncoulomb = 1.0\nstiffness = 100\ndamping = 1\n",
        )],
        _ => vec![text("examples/three-joint.urdf")?],
    })
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

/// An array of NumPy, version 1.0: rows × columns of doubles.
fn npy(rows: usize, columns: usize) -> Vec<u8> {
    let head =
        format!("{{'descr': '<f8', 'fortran_order': False, 'shape': ({rows}, {columns}), }}");
    let head = format!("{head:<117}\n");
    let mut bytes = b"\x93NUMPY\x01\x00".to_vec();
    bytes.extend(u16::try_from(head.len()).unwrap_or(u16::MAX).to_le_bytes());
    bytes.extend(head.bytes());
    bytes.extend((0..rows * columns).flat_map(|k| (0.01 * k as f64).to_le_bytes()));
    bytes
}

/// A matrix of MATLAB, version 5: rows × columns of doubles.
fn matrix(name: &str, rows: usize, columns: usize) -> Vec<u8> {
    let element = |kind: u32, content: Vec<u8>| {
        let mut bytes = kind.to_le_bytes().to_vec();
        bytes.extend(u32::try_from(content.len()).unwrap_or(u32::MAX).to_le_bytes());
        bytes.extend(content);
        bytes.resize(bytes.len().next_multiple_of(8), 0);
        bytes
    };
    let sizes = [rows, columns].map(|size| u32::try_from(size).unwrap_or(0).to_le_bytes());
    let values = (0..rows * columns).flat_map(|k| (0.01 * k as f64).to_le_bytes()).collect();
    let parts = [
        element(6, vec![6, 0, 0, 0, 0, 0, 0, 0]),
        element(5, sizes.concat()),
        element(1, name.as_bytes().to_vec()),
        element(9, values),
    ];
    element(14, parts.concat())
}
