//! The tables of results, for people and for programs.
use crate::compare::{Differences, TOLERANCE};
use crate::times::Times;
use crate::{FRAMES, Measured, Report, Row};

const PARTS: [&str; 6] = ["large scale", "normals", "detail", "normals", "rearranging", "whole"];

pub(crate) fn print_json(report: &Report) {
    match serde_json::to_string_pretty(report) {
        Ok(json) => println!("{json}"),
        Err(e) => eprintln!("error: {e}"),
    }
}

pub(crate) fn print(report: &Report) {
    let Report {
        rig,
        vertices,
        handles,
        strain_edges,
        centers,
        influences,
        machine,
        threads,
        version,
        peers,
    } = report;
    println!(
        "{rig}: {vertices} vertices, {handles} handles, {strain_edges} strain edges, {centers} centres, {influences} influences"
    );
    println!("Rhytid {version} on {machine}, {threads} threads for everyone\n");
    print_part("One frame, ms", peers, |row| &row.frame);
    print_part(&format!("{FRAMES} frames at once, ms per frame"), peers, |row| &row.batch);
    println!(
        "Medians. “detail” is with strain and tangent frames. The two columns at the right: how many times as fast"
    );
    println!(
        "Rhytid was in turns with that peer, with its basis as f32 and as f16. Every peer agrees with Rhytid:"
    );
    for Row { name, detail, differences: Differences { positions, rounded, normals }, .. } in peers {
        println!("  {name} ({detail})");
        println!(
            "    positions to {positions:.1e} of the largest displacement ({rounded} of {} beyond {TOLERANCE:e}, where \
             large weights cancel), normals to {normals:.1e}",
            vertices * (FRAMES + 1)
        );
    }
}

fn print_part(title: &str, peers: &[Row], part: impl Fn(&Row) -> &Measured) {
    print!("{title:<32}");
    PARTS.iter().for_each(|part| print!("{part:>13}"));
    println!("{:>9}{:>9}", "f32", "f16");
    for row in peers {
        let Measured { peer, rhytid_f32, rhytid_f16 } = part(row);
        print_times(&row.name, peer);
        println!("{:>7.2} ×{:>7.2} ×", peer.whole / rhytid_f32.whole, peer.whole / rhytid_f16.whole);
        print_times("  Rhytid beside it, f32", rhytid_f32);
        println!();
        print_times("  Rhytid beside it, f16", rhytid_f16);
        println!();
    }
    println!();
}

fn print_times(name: &str, times: &Times) {
    print!("{name:<32}");
    for ms in times.parts() {
        if ms > 0.0 { print!("{ms:>13.2}") } else { print!("{:>13}", "") }
    }
}
