//! Arrays of NumPy and MATLAB: read as columns, time along their longer side.
use crate::made_mats::{compressed, doubles, element, mat_of, small_element, structure, variable};
use crate::{file_of, with};
use ndarray::{Array1, Array2, ShapeBuilder};
use ndarray_npy::NpzWriter;
use std::fs::File;
use std::io::Write;
use std::path::Path;
use tempfile::TempPath;
use torquewise_logs::{LogError, Logs, Options, Profile};
use torquewise_motion::Motion;

const ROWS: usize = 30;

fn t() -> Array1<f64> {
    (0..ROWS).map(|row| 0.01 * row as f64).collect()
}

/// Value of joint `joint` at `row`: any that tells rows and joints apart.
fn value(row: usize, joint: usize) -> f64 {
    row as f64 + 100.0 * (joint + 1) as f64
}

fn tall(n: usize) -> Array2<f64> {
    Array2::from_shape_fn((ROWS, n), |(row, joint)| value(row, joint))
}

fn whole(n: usize) -> Array2<u16> {
    Array2::from_shape_fn((ROWS, n), |(row, joint)| u16::try_from(row + 100 * (joint + 1)).unwrap())
}

fn read(file: &Path, options: &Options) -> Result<Motion, LogError> {
    Ok(crate::read_both(file, options)?.remove(0))
}

fn assert_is_read(motion: &Motion, factor: f64) {
    assert_eq!((motion.n_rows(), motion.n_joints()), (ROWS, 2));
    assert_eq!(motion.t(), t().as_slice().unwrap());
    for (row, joint) in [(0, 0), (7, 1), (ROWS - 1, 0), (ROWS - 1, 1)] {
        let expected = factor * value(row, joint);
        assert!((motion.q()[(row, joint)] - expected).abs() < 1e-12 * expected, "{row} {joint}");
    }
}

fn npz(add: impl FnOnce(&mut NpzWriter<File>)) -> TempPath {
    let file = file_of(".npz", b"");
    let mut writer = NpzWriter::new_compressed(File::create(&file).unwrap());
    add(&mut writer);
    writer.finish().unwrap();
    file
}

fn mat(variables: &[Vec<u8>]) -> TempPath {
    file_of(".mat", &mat_of(variables))
}

#[test]
fn arrays_in_any_order_and_type_are_read_as_columns() {
    let fortran = Array2::from_shape_fn((ROWS, 2).f(), |(row, joint)| value(row, joint));
    let flat = tall(2).reversed_axes();
    for layout in 0..4 {
        let file = npz(|file| {
            file.add_array("t", &t()).unwrap();
            match layout {
                0 => file.add_array("q", &tall(2)).unwrap(),
                1 => file.add_array("q", &fortran).unwrap(),
                2 => file.add_array("q", &flat.as_standard_layout()).unwrap(),
                _ => file.add_array("q", &whole(2).mapv(f32::from)).unwrap(),
            }
            file.add_array("dq", &whole(2).mapv(i64::from)).unwrap();
            file.add_array("ddq", &whole(2)).unwrap();
            file.add_array("scalar", &Array1::from(vec![1.0])).unwrap();
        });

        let motion = read(&file, &Options::default()).unwrap();

        assert_is_read(&motion, 1.0);
        assert_eq!((motion.dq()[(3, 1)], motion.ddq()[(3, 0)]), (203.0, 103.0));
    }
}

#[test]
fn a_profile_maps_arrays_and_a_vector_is_a_column_of_its_own() {
    let file = npz(|file| {
        file.add_array("stamp", &t().mapv(|t| (1e3 * t).round())).unwrap();
        file.add_array("pos", &tall(2)).unwrap();
        file.add_array("first", &tall(1).column(0).to_owned()).unwrap();
    });
    let clock = "t = { column = \"stamp\", unit = \"ms\" }\n";

    let two = read(&file, &with(&format!("{clock}q = {{ columns = \"pos\", unit = \"deg\" }}")));
    let one = read(&file, &with(&format!("{clock}q = {{ columns = \"first\" }}"))).unwrap();

    assert_eq!((one.n_joints(), one.q()[(4, 0)]), (1, 104.0));
    let two = two.unwrap();
    assert!((two.q()[(4, 1)] - 204_f64.to_radians()).abs() < 1e-12);
    assert!((two.t()[7] - 0.07).abs() < 1e-15);
}

#[test]
fn the_profile_of_the_simulated_arm_reads_what_its_comment_says_to_save() {
    let file = npz(|file| {
        file.add_array("t", &t()).unwrap();
        for (name, offset) in [("q", 0.0), ("dq", 1.0), ("ddq", 2.0), ("tau", 3.0)] {
            file.add_array(name, &(tall(2) + offset)).unwrap();
        }
    });
    let path = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../profiles/delan_character.toml");
    let options = Options { profile: Some(Profile::read(&path).unwrap()), ..Options::default() };

    let motion = read(&file, &options).unwrap();

    assert_is_read(&motion, 1.0);
    assert_eq!((motion.dq()[(2, 0)], motion.ddq()[(2, 1)]), (103.0, 204.0));
    assert_eq!((motion.require_tau().unwrap()[(2, 1)], motion.n_rows()), (205.0, ROWS));
}

#[test]
fn arrays_of_another_length_are_refused_if_they_are_used() {
    let file = npz(|file| {
        file.add_array("t", &t()).unwrap();
        file.add_array("q", &Array2::<f64>::zeros((ROWS + 1, 2))).unwrap();
        file.add_array("gain", &Array1::<f64>::zeros(7)).unwrap();
    });

    let refused = read(&file, &Options::default()).unwrap_err().to_string();

    assert!(refused.contains("column q1 has 31 values, column t has 30"), "{refused}");
}

/// An archive with one array q whose header is as given.
fn archive(header: &str, body: &[u8]) -> TempPath {
    let file = file_of(".npz", b"");
    let mut zip = zip::ZipWriter::new(File::create(&file).unwrap());
    zip.start_file("q.npy", zip::write::SimpleFileOptions::default()).unwrap();
    zip.write_all(b"\x93NUMPY\x01\x00").unwrap();
    zip.write_all(&u16::try_from(header.len()).unwrap().to_le_bytes()).unwrap();
    zip.write_all(header.as_bytes()).unwrap();
    zip.write_all(body).unwrap();
    zip.finish().unwrap();
    file
}

#[test]
fn an_array_that_claims_more_than_it_has_allocates_nothing() {
    let options = with("rate = 100.0\nq = { columns = \"q\" }");
    for shape in ["(4000000000000, 2)", "(18446744073709551615, 2)", "(9, 1)"] {
        let header = format!("{{'descr': '<f8', 'fortran_order': False, 'shape': {shape}}}\n");
        let refused = read(&archive(&header, &[0; 64]), &options);
        assert!(matches!(refused, Err(LogError::Array { .. })), "{shape}");
    }
    let deep = format!("{{'descr': {}", "(".repeat(60_000));
    let refused = read(&archive(&deep, b""), &Options::default());
    assert!(matches!(refused, Err(LogError::Array { .. })), "{refused:?}");
}

#[test]
fn a6_names_of_many_arrays_take_no_more_than_stated() {
    // 100 000 elements of a structure, whose one field has a name of 64 kB.
    let name = vec![b'n'; 65_535];
    let field = variable(6, [2, 1], "", &[element(9, &[0; 16])]);
    let content = [
        small_element(5, &65_536_i32.to_le_bytes()),
        element(1, &[&name[..], &[0]].concat()),
        field.repeat(100_000),
    ];
    let long = mat(&[compressed(&variable(2, [1, 100_000], "s", &content))]);
    let refused = read(&long, &Options::default());
    assert!(matches!(refused, Err(LogError::NoColumn { .. })), "{refused:?}");

    // Empty fields take no time either.
    let content = [
        small_element(5, &8_i32.to_le_bytes()),
        element(1, b"field\0\0\0"),
        element(14, b"").repeat(1_100_000),
    ];
    let fields = mat(&[compressed(&variable(2, [1, 1_100_000], "c", &content))]);
    let refused = read(&fields, &Options::default()).unwrap_err();
    assert!(format!("{refused:?}").contains("over 1000000"), "{refused:?}");
}

#[test]
fn a8_arrays_of_long_names_and_too_many_columns_are_passed_over_or_refused() {
    let long = npz(|file| {
        for k in 0..50 {
            file.add_array(format!("{k}{}", "n".repeat(60_000)), &t()).unwrap();
        }
    });
    let refused = read(&long, &Options::default());
    assert!(matches!(refused, Err(LogError::NoColumn { .. } | LogError::Decode { .. })));

    let many = npz(|file| {
        for k in 0..60 {
            file.add_array(format!("a{k}"), &Array2::<f64>::zeros((256, 256))).unwrap();
        }
    });
    assert!(matches!(read(&many, &Options::default()), Err(LogError::TooManyColumns { .. })));
}

/// Most memory that the process has held since it was asked to forget, in bytes.
#[cfg(target_os = "linux")]
fn peak_memory() -> usize {
    let status = std::fs::read_to_string("/proc/self/status").unwrap();
    let peak = status.lines().find_map(|line| line.strip_prefix("VmHWM:")).unwrap();
    1_000 * peak.trim().trim_end_matches("kB").trim().parse::<usize>().unwrap()
}

#[cfg(target_os = "linux")]
#[test]
fn a7_a11_memory_does_not_grow_with_the_rows_of_arrays() {
    const LONG: usize = 8_000_000;
    let zeros = vec![0; LONG];
    let archive = npz(|file| {
        file.add_array("q", &Array1::from(zeros.iter().map(|_| 0_i8).collect::<Vec<_>>())).unwrap();
    });
    let matrix = variable(6, [LONG, 1], "q", &[element(1, &zeros)]);
    let packed = compressed(&matrix);
    drop((matrix, zeros));
    for file in [archive, mat(&[packed])] {
        let options = with("rate = 1000.0\nq = { columns = \"q\" }");
        let logs = Logs::open_with(&[file.to_path_buf()], &options);
        // From here on the peak counts, where the system lets it be forgotten.
        let _ = std::fs::write("/proc/self/clear_refs", "5");
        let before = peak_memory();
        let mut rows = 0;
        let counted = logs.unwrap().read_raw::<LogError>(None, &mut |_, block| {
            rows += block.t.len();
            assert!(block.t.len() <= 1_024);
            Ok(())
        });

        counted.unwrap();
        assert_eq!(rows, LONG);
        // The bytes alone would be 8 MB, the numbers 64 MB.
        let grown = peak_memory() - before;
        assert!(grown < 4_000_000, "{grown} bytes more");
    }
}

#[test]
fn a_changed_byte_of_an_array_is_noticed() {
    let file = file_of(".npz", b"");
    let mut writer = NpzWriter::new(File::create(&file).unwrap());
    writer.add_array("t", &t()).unwrap();
    writer.add_array("q", &tall(2)).unwrap();
    writer.finish().unwrap();
    let options = with("t = { column = \"t\" }\nq = { columns = \"q\" }");
    assert_is_read(&read(&file, &options).unwrap(), 1.0);

    let mut bytes = std::fs::read(&file).unwrap();
    let place = bytes.windows(8).position(|own| own == value(7, 1).to_le_bytes()).unwrap();
    bytes[place] ^= 1;
    std::fs::write(&file, bytes).unwrap();

    assert!(read(&file, &options).is_err());
}

fn column(values: &Array1<f64>) -> Array2<f64> {
    values.clone().insert_axis(ndarray::Axis(1))
}

/// Variables as a recorder would leave them: a structure in a structure, small types, text.
fn record() -> Vec<Vec<u8>> {
    let small: Vec<u8> = (0..ROWS).map(|row| u8::try_from(row).unwrap()).collect();
    let inner = structure("", &[("deg", doubles("", &tall(2).reversed_axes().to_owned()))]);
    let fields = [
        ("time", doubles("", &column(&t()))),
        ("pos", inner),
        ("steps", variable(6, [1, ROWS], "", &[element(2, &small)])),
        ("nothing", element(14, b"")),
    ];
    let record = structure("rec", &fields);
    let text = variable(4, [1, 3], "note", &[small_element(4, b"abc")]);
    vec![text, record, doubles("gain", &tall(2))]
}

const RECORD: &str = "t = { column = \"rec.time\" }\n\
    q = { columns = \"rec.pos.deg\", unit = \"deg\" }\n\
    tau = { columns = [\"rec.steps\", \"gain2\"] }";

#[test]
fn structures_are_read_whether_they_are_compressed_or_not() {
    let packed: Vec<_> = record().iter().map(|variable| compressed(variable)).collect();
    for variables in [record(), packed] {
        let motion = read(&mat(&variables), &with(RECORD)).unwrap();

        assert_is_read(&motion, 1_f64.to_radians());
        let tau = motion.require_tau().unwrap();
        assert_eq!((tau[(9, 0)], tau[(9, 1)]), (9.0, 209.0));
    }
    // Columns of plain names need no profile.
    let file = mat(&[doubles("t", &column(&t())), compressed(&doubles("q", &tall(2)))]);
    assert_is_read(&read(&file, &Options::default()).unwrap(), 1.0);
}

#[test]
fn encodings_that_are_not_read_are_told() {
    let file = mat(&[]);
    let mut bytes = std::fs::read(&file).unwrap();
    for (version, reason) in [(b"\0\x02IM", "version 7.3"), (b"\x01\0MI", "big-endian")] {
        bytes[124..].copy_from_slice(version);
        std::fs::write(&file, &bytes).unwrap();
        let refused = format!("{:?}", read(&file, &Options::default()).unwrap_err());
        assert!(refused.contains(reason), "{refused}");
    }
    let cells = variable(1, [2, 1], "q", &[doubles("", &tall(1)), doubles("", &tall(1))]);
    let file = mat(&[cells, doubles("t", &column(&t()))]);
    let refused = read(&file, &with("rate = 1.0\nq = { columns = \"q\" }")).unwrap_err();
    assert!(format!("{refused:?}").contains("holds cells"), "{refused:?}");
    // Cells that are not asked for do no harm.
    assert!(read(&file, &with("rate = 1.0\nq = { columns = \"t\" }")).is_ok());
}

/// Sound files: the bytes of each, how it is read, and where it is to stand.
fn sound() -> [(Vec<u8>, Options, TempPath); 3] {
    let packed: Vec<_> = record().iter().map(|variable| compressed(variable)).collect();
    let archive = npz(|file| {
        file.add_array("t", &t()).unwrap();
        file.add_array("q", &tall(2)).unwrap();
    });
    let sound = |file: TempPath, options| (std::fs::read(&file).unwrap(), options, file);
    [
        sound(mat(&record()), with(RECORD)),
        sound(mat(&packed), with(RECORD)),
        sound(archive, Options::default()),
    ]
}

#[test]
fn a_file_cut_short_is_refused_wherever_it_ends() {
    for (whole, options, file) in sound() {
        std::fs::write(&file, &whole).unwrap();
        assert!(read(&file, &options).is_ok());
        for end in (0..whole.len()).step_by(64) {
            std::fs::write(&file, &whole[..end]).unwrap();
            assert!(read(&file, &options).is_err(), "cut to {end} of {} bytes", whole.len());
        }
    }
}
