//! Files with ambiguous columns or numbers: the interpretation, and the advice of the message.

use super::{ReadOptions, doubles, error, npy, read, read_as, read_with};

/// As in the Gaia catalogue: the same places in two systems, which differ by a rotation.
#[test]
fn celestial_systems_beside_each_other() {
    let both = "source_id,ra,dec,l,b,weight\n1,12.5,-7,280,60,0.5\n2,350,80,111,19,0.25\n";
    let got = read("g.csv", both);
    let equatorial = read_as("g.csv", both, "ra=ra,dec=dec,w=weight").unwrap();
    assert_eq!(got.sets, equatorial.sets);
    assert_eq!(
        got.remarks,
        [
            "g.csv: columns not used: source_id,l,b",
            "g.csv: directions are ra,dec; use --columns l=l,b=b,w=weight for others",
        ]
    );
    let galactic = read_as("g.csv", both, "l=l,b=b,w=weight").unwrap();
    assert_ne!(got.sets, galactic.sets);
    assert_eq!(galactic.remarks.len(), 1, "{:?}", galactic.remarks);
    let three = read("g.csv", "GLON,GLAT,l,b\n1,2,3,4\n");
    assert_eq!(three.sets, read("g.csv", "lon,lat\n1,2\n").sets);
    assert!(three.remarks[1].contains("directions are glon,glat; use --columns l=l,b=b"));
    // One complete system, and one with a component missing.
    assert_eq!(read("g.csv", "ra,dec,l\n1,2,3\n").remarks, ["g.csv: column not used: l"]);
}

#[test]
fn advice_can_be_typed() {
    let cases = [
        (
            "RA,DEC,Z,x,y\n1,2,3,4,5\n",
            "one way to name the point",
            "ra=RA,dec=DEC or --columns x=x,y=y,z=Z",
        ),
        ("DESI_RA,DESI_DEC,Z\n1,2,3\n", "the column x and y", "ra=DESI_RA,dec=DESI_DEC"),
        (
            "RA_ICRS,DE_ICRS,_RAJ2000,_DEJ2000\n1,2,3,4\n",
            "the column ra once",
            "ra=RA_ICRS,dec=DE_ICRS or --columns ra=_RAJ2000,dec=_DEJ2000",
        ),
        ("c.ra,c.dec,w\n1,2,3\n", "columns named x,y,z", "ra=c.ra,dec=c.dec,w=w"),
        (
            "x,y,z,theta,phi\n1,0,0,1,0\n",
            "one way to name the point",
            "x=x,y=y,z=z or --columns theta=theta,phi=phi",
        ),
    ];
    for (content, expected, flags) in cases {
        let message = error("p.csv", content);
        let advice = format!("; use --columns {flags}");
        assert!(message.contains(expected) && message.ends_with(&advice), "{message}");
        // The first flag is a valid one for the directions of these columns.
        let flag = flags.split(" or ").next().unwrap();
        let got = read_as("p.csv", content, flag).unwrap_or_else(|e| panic!("{flag}: {e}"));
        assert_eq!(got.sets[0].points.len(), 1, "{flag}");
    }
    // For any number of columns.
    let wide: Vec<String> = (0..50_000).map(|i| format!("ra_{i}")).collect();
    let message = error("p.csv", format!("{},dec_7\n", wide.join(",")));
    assert!(message.ends_with("use --columns ra=ra_7,dec=dec_7"), "{message}");
    for content in ["a,b,c\n1,2,3\n", "x,y,magnitude\n1,2,3\n", "x,y,z,w,weight\n1,2,3,4,5\n"] {
        assert!(!error("p.csv", content).contains("; use"), "{content}");
    }
}

#[test]
fn notations_that_are_not_supported_are_named() {
    for (number, advice) in [
        ("05:34:31.9", "decimal degrees"),
        ("5h34m32s", "decimal degrees"),
        ("+22d00m52.2s", "decimal degrees"),
        ("05 34 31.9", ""),
        ("83,63", "decimal commas"),
        ("1.5d3", ""),
        ("n/a", ""),
        ("--", ""),
    ] {
        let message = error("p.csv", format!("ra;dec\n{number};2\n"));
        assert!(message.contains(&format!("ra: expected a finite number, got \"{number}\"")));
        assert_eq!(message.contains(';'), !advice.is_empty(), "{message}");
        assert!(message.contains(advice), "{message}");
    }
    let transposed = "{'descr': '<f8', 'fortran_order': False, 'shape': (3, 4), }";
    let message = error("p.npy", npy(transposed, &doubles(&[0.5; 12])));
    assert!(message.contains("array.T"), "{message}");
    let message = error("p.csv", b"ra,dec,name\n1,2,M\xfcller\n");
    assert!(message.contains("iconv -f LATIN1 -t UTF-8"), "{message}");
}

#[test]
fn unsupported_formats_come_with_advice() {
    for (start, parts) in [
        (b"PAR1\x15\x04".as_slice(), &["Parquet", "pandas.read_parquet", "to_csv"][..]),
        (b"ARROW1\0\0", &["Arrow", "read_feather"]),
        (b"FEA1\0\0", &["Feather", "read_feather"]),
        (b"\x89HDF\r\n\x1a\n", &["HDF5", "h5py"]),
        (b"MATLAB 5.0 MAT-file, Platform: posix", &["MATLAB", "loadmat"]),
        (b"\x80\x04\x95\x9c", &["pickle", "numpy.save"]),
        (b"SQLite format 3\0", &["SQLite", "sqlite3 -header -csv"]),
        (b"BZh91AY&SY", &["bzip2", "decompress"]),
        (b"<VOTABLE version=\"1.4\">", &["VOTable", "OUT.fits"]),
    ] {
        let message = read_with("p.dat", start, &ReadOptions::default()).unwrap_err();
        for part in parts.iter().chain(&["not supported", "CSV"]) {
            assert!(message.contains(part), "{part}: {message}");
        }
    }
}

/// The first table of a file is often not a catalogue.
#[test]
fn other_tables_of_a_fits_file_are_listed() {
    let message = error("m.fits", include_bytes!("../../../../tests/data/mixed.fits"));
    let expected = "the columns RA (this is the first table; --hdu chooses another: [2] table MAP)";
    assert!(message.ends_with(expected), "{message}");
    let message = error("r.fits", include_bytes!("../../../../tests/data/ring.fits"));
    assert!(message.ends_with("(it is the only table)"), "{message}");
}
