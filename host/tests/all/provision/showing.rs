//! `flotilla provision --show`: what an image holds, and every way in which it can be wrong.

use super::*;

#[test]
fn what_an_image_holds_is_shown_without_its_secrets() {
    let folder = with(MODBOAT);
    done(&provision(folder.path(), &["--id", "3", "--from", "m.toml"]));
    done(&provision(folder.path(), &["--id", "3", "--from", "m.toml", "--bin"]));
    let made = configuration(&folder.path().join("module-3.uf2"));
    for (name, place) in [("module-3.uf2", "UF2 for 0x101ff000"), ("module-3.bin", "a bare image")] {
        let output = provision(folder.path(), &["--show", name]);
        let said = done(&output);
        let head = format!(
            "# {name}: {place}\n# module 3 of fleet {}, a Modboat\n# key: there, not shown\n# passphrase: there, not shown\n\n\
             [network]\nssid = \"tank\"\nhost = \"192.168.4.1:4870\"\n",
            made.fleet
        );
        assert!(said.starts_with(&head), "{said}");
        assert!(
            said.contains("\n[modboat.servo]\n") && said.contains("\namplitude_max_rad = 2.6\n"),
            "{said}"
        );
        assert_silent(&output, &made);
    }
}

#[test]
fn every_fault_of_an_image_is_named() {
    let folder = with(MODBOAT);
    done(&provision(folder.path(), &["--id", "3", "--from", "m.toml", "--out", "a.bin"]));
    let good = fs::read(folder.path().join("a.bin")).expect("a file");
    let made = Configuration::read(&good).expect("valid");
    let checked = |mut image: Vec<u8>| {
        let end = image.len() - 4;
        let checksum = crc::Crc::<u32>::new(&crc::CRC_32_ISO_HDLC).checksum(&image[..end]);
        image[end..].copy_from_slice(&checksum.to_le_bytes());
        image
    };
    let with = |at: usize, byte: u8| {
        let mut image = good.clone();
        image[at] = byte;
        image
    };
    let block = |address: u32, family| uf2::write(family, [(address, &good[..100])]).expect("UF2");
    for (file, expected) in [
        (with(good.len() - 1, !good[good.len() - 1]), "a.bin: wrong checksum: checksum "),
        (with(40, !good[40]), "a.bin: wrong checksum: checksum "),
        (with(4, 9), "a.bin: wrong version: format 9, this build reads 3"),
        // The first field is the module's number.
        (checked(with(8, 0)), "a.bin: id out of range: module 0: numbers go from 1 to 1024"),
        (checked([&good[..8], &[0xFF; 60], &[0; 4]].concat()), "a.bin: cut short: "),
        (with(7, 0xFF), "a.bin: wrong length: "),
        (good[..50].to_vec(), "a.bin: cut short: the block has 50 bytes"),
        (vec![0xFF; 4096], "a.bin: no configuration: begins with [ff, ff, ff, ff]"),
        (Vec::new(), "a.bin: cut short: "),
        (
            block(0x1000_0000, Family::ABSOLUTE),
            "a.bin: block 1 is for 0x10000000: a configuration is in one piece from 0x101ff000 on",
        ),
        (
            block(0x101f_f000, Family::RP2350_ARM_S),
            "a.bin: is for rp2350-arm-s: a configuration is for absolute",
        ),
        (
            block(0x101f_f000, Family::ABSOLUTE)[..511].to_vec(),
            "a.bin: is no UF2 file: 511 bytes are no whole number",
        ),
        (block(0x101f_f000, Family::ABSOLUTE), "a.bin: wrong checksum: "),
    ] {
        fs::write(folder.path().join("a.bin"), file).expect("a file");
        let output = provision(folder.path(), &["--show", "a.bin"]);
        let said = refused(&output);
        assert!(said.starts_with(expected), "{said}\nexpected {expected}");
        assert_silent(&output, &made);
    }
    let said = refused(&provision(folder.path(), &["--show", "none.bin"]));
    assert!(said.starts_with("none.bin: No such file"), "{said}");
}

/// What protocol takes and the firmware does not: an image made by another program.
#[test]
fn an_image_that_the_firmware_refuses_is_named() {
    let folder = with(MODBOAT);
    done(&provision(folder.path(), &["--id", "3", "--from", "m.toml", "--out", "a.bin"]));
    let mut made = configuration(&folder.path().join("a.bin"));
    if let Robot::Modboat(tail) = &mut made.robot {
        tail.servo.time_constant_s = -1.0;
    }
    fs::write(folder.path().join("a.bin"), made.write(&mut [0; IMAGE_MAX]).expect("finite")).expect("a file");
    let said = refused(&provision(folder.path(), &["--show", "a.bin"]));
    assert_eq!(
        said,
        "a.bin: configuration: servo.time_constant_s = -1 s: must be a finite number greater than zero"
    );
}
