//! A log written and read back: whole, cut at every byte, damaged, and as tables.

use std::io;

use super::message::Message;
use super::reader::{Extent, LogError, read};
use super::schema::Schema;
use super::table::Table;
use super::writer::Writer;
use super::{flotilla, ros};

/// A sink that the test can look at.
#[derive(Clone, Default)]
struct Sink(std::rc::Rc<std::cell::RefCell<Vec<u8>>>);

impl io::Write for Sink {
    fn write(&mut self, bytes: &[u8]) -> io::Result<usize> {
        self.0.borrow_mut().extend(bytes);
        Ok(bytes.len())
    }

    fn flush(&mut self) -> io::Result<()> {
        Ok(())
    }
}

fn state(step: u64) -> flotilla::BoatState {
    flotilla::BoatState {
        stamp: ros::Time::from_nanos(step * 50_000_000),
        heading_rad: 0.1 * step as f64,
        ..flotilla::BoatState::default()
    }
}

/// Five seconds of states at 20 Hz, and what had been written after each.
fn log(finish: bool) -> (Vec<u8>, Vec<usize>) {
    let sink = Sink::default();
    let mut writer = Writer::new(sink.clone()).expect("writes");
    let topic = writer.topic::<flotilla::BoatState>("/truth/state").expect("writes");
    let mut lengths = Vec::new();
    for step in 0..100 {
        writer.write(topic, step * 50_000_000, &state(step)).expect("writes");
        lengths.push(sink.0.borrow().len());
    }
    if finish {
        writer.finish().expect("writes");
    } else {
        drop(writer);
    }
    let bytes = sink.0.borrow().clone();
    (bytes, lengths)
}

fn headings(bytes: &[u8]) -> Result<(Vec<f64>, Extent), LogError> {
    let mut found = Vec::new();
    let extent = read(bytes, |entry, _| {
        found.push(entry.read::<flotilla::BoatState>()?.heading_rad);
        Ok::<(), LogError>(())
    })?;
    Ok((found, extent))
}

#[test]
fn what_is_written_is_read() {
    let (bytes, _) = log(true);
    let (found, extent) = headings(&bytes).expect("reads");
    assert_eq!(found, (0..100).map(|step| 0.1 * f64::from(step)).collect::<Vec<_>>());
    assert_eq!((extent.whole, extent.messages, extent.end_ns), (true, 100, 4_950_000_000));
}

#[test]
fn a_log_that_is_cut_anywhere_reads_up_to_there() {
    let (bytes, lengths) = log(true);
    let whole = headings(&bytes).expect("reads").0;
    let mut most = 0;
    for length in 5..bytes.len() {
        let (found, extent) = headings(&bytes[..length]).unwrap_or_else(|error| panic!("{length}: {error}"));
        assert!(!extent.whole, "of {length} bytes");
        assert_eq!(found, whole[..found.len()], "of {length} bytes");
        assert!(found.len() >= most, "of {length} bytes");
        most = found.len();
    }
    assert_eq!(most, 100);
    // What is out of the process reaches to within a chunk of the last message, whenever the process ends.
    for (step, &length) in lengths.iter().enumerate() {
        let found = if length < 5 { 0 } else { headings(&bytes[..length]).expect("reads").0.len() };
        assert!(found + 20 > step, "after step {step}: {found} messages");
    }
}

#[test]
fn what_is_no_log_or_damaged_is_named() {
    for text in [&b""[..], b"\x89M", b"name = \"a scenario\"\n", b"\x89PNG\r\n"] {
        assert!(matches!(headings(text), Err(LogError::NoLog)), "{text:?}");
    }
    let (mut bytes, _) = log(true);
    let middle = bytes.len() / 2;
    bytes[middle] ^= 1;
    let said = headings(&bytes).expect_err("damaged").to_string();
    assert_eq!(said, "damaged after 1.950 s: a check sum is wrong");
}

#[test]
fn tables_are_tidy() {
    let rows = |name: &str, schema: String, messages: &[Vec<u8>]| {
        let mut table = Table::new(Schema::parse(name, &schema).expect(name));
        let mut out = Vec::new();
        table.write_header(&mut out).expect("writes");
        for (index, message) in messages.iter().enumerate() {
            table.take(message).expect("reads");
            table.write_rows(1_500_000_000 + index as u64, &mut out).expect("writes");
        }
        String::from_utf8(out).expect("text")
    };
    fn bytes(message: &impl Message) -> Vec<u8> {
        let mut encoder = super::cdr::Encoder::default();
        message.write(&mut encoder);
        encoder.bytes().to_vec()
    }
    let joints = ros::JointState {
        header: ros::Header { stamp: ros::Time { sec: 1, nanosec: 5 }, frame_id: "a,\"b\"".to_owned() },
        name: vec!["tail_1".to_owned(), "tail_2".to_owned()],
        position: vec![0.1, -1e-9],
        velocity: vec![2.0, 0.3],
        effort: Vec::new(),
    };
    assert_eq!(
        rows(ros::JointState::NAME, ros::JointState::schema(), &[bytes(&joints)]),
        "t_s,index,header_stamp_s,header_frame_id,name,position_rad,velocity_rad_s,effort_nm\n\
         1.500000000,0,1.000000005,\"a,\"\"b\"\"\",tail_1,0.1,2.0,\n\
         1.500000000,1,1.000000005,\"a,\"\"b\"\"\",tail_2,-1e-9,0.3,\n"
    );
    let wrench = ros::WrenchStamped::default();
    let text = rows(ros::WrenchStamped::NAME, ros::WrenchStamped::schema(), &[bytes(&wrench)]);
    assert_eq!(
        text.lines().next(),
        Some(
            "t_s,header_stamp_s,header_frame_id,wrench_force_x_n,wrench_force_y_n,wrench_force_z_n,\
             wrench_torque_x_nm,wrench_torque_y_nm,wrench_torque_z_nm"
        )
    );
    // One or none is one column; a list within a list is one cell; nothing in any list is no row.
    let place = flotilla::Place { x_m: 1.0, y_m: 2.0, z_m: 3.0, yaw_rad: 4.0 };
    let robot =
        |reference| flotilla::Robot { thrusts_n: vec![1.5, -2.0], reference, ..flotilla::Robot::default() };
    let robots =
        flotilla::Robots { robots: vec![robot(None), robot(Some(place))], ..flotilla::Robots::default() };
    let text = rows(flotilla::Robots::NAME, flotilla::Robots::schema(), &[bytes(&robots)]);
    let lines: Vec<&str> = text.lines().collect();
    let column = |name: &str| lines[0].split(',').position(|known| known == name).expect(name);
    let cells: Vec<Vec<&str>> = lines[1..].iter().map(|line| line.split(',').collect()).collect();
    assert_eq!((cells.len(), cells[0].len(), cells[1].len()), (2, cells[0].len(), cells[0].len()));
    assert_eq!(cells[0][column("robots_thrusts_n")], "1.5;-2.0");
    assert_eq!(cells[0][column("robots_reference_yaw_rad")], "");
    assert_eq!(cells[1][column("robots_reference_yaw_rad")], "4.0");
    let none = flotilla::Absences::default();
    assert_eq!(
        rows(flotilla::Absences::NAME, flotilla::Absences::schema(), &[bytes(&none)]).lines().count(),
        1
    );
}
