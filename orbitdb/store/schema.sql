-- The tables of a catalogue (orbitdb/store/schema.py). A table comes after the tables that it refers to.

-- The half lengths a for which something is stored.
CREATE TABLE stadium (
    id INTEGER NOT NULL,
    a REAL NOT NULL,
    PRIMARY KEY (id),
    CONSTRAINT uq_stadium_a UNIQUE (a)
) STRICT;

-- The run of the program that wrote a row: when it started (UTC), the version, its parameters as JSON, and
-- its number of transactions, which tells whether a journal belongs to this file.
CREATE TABLE run (
    id INTEGER NOT NULL,
    started TEXT NOT NULL,
    version TEXT NOT NULL,
    parameters TEXT NOT NULL,
    commits INTEGER DEFAULT 0 NOT NULL,
    PRIMARY KEY (id)
) STRICT;

-- One symmetry class: its least word, its number of words, its number of bounces on straight walls, and all
-- its words one after another, p symbols each, in the order of the elements that lead to them, beginning with
-- the least word. The id is the key of the least word (orbitdb.symbols.words.key); classes of longer words
-- are numbered from LONG up.
CREATE TABLE cycle (
    id INTEGER NOT NULL,
    p INTEGER NOT NULL,
    word TEXT NOT NULL,
    class_size INTEGER NOT NULL,
    walls INTEGER NOT NULL,
    time_reversal TEXT NOT NULL,
    symmetry TEXT NOT NULL,
    words TEXT NOT NULL,
    PRIMARY KEY (id)
) STRICT;

-- The element that leads to the n-th word of a class with this symmetry, counted from 0. Every file has the
-- same rows.
CREATE TABLE element (
    symmetry TEXT NOT NULL,
    n INTEGER NOT NULL,
    element INTEGER NOT NULL,
    PRIMARY KEY (symmetry, n)
) WITHOUT ROWID, STRICT;

-- Words that break geometric rules, as least rotations (fill --geometric). They have no class. The id is
-- minus the key of the word; longer words are numbered from -LONG down.
CREATE TABLE pruned (
    id INTEGER NOT NULL,
    p INTEGER NOT NULL,
    word TEXT NOT NULL,
    rules TEXT NOT NULL,
    PRIMARY KEY (id),
    CONSTRAINT uq_pruned_p UNIQUE (p, word)
) STRICT;

-- The result for a class at one value of a; the coordinates, in little-endian float64, and the sign of the
-- area are those of the least word.
CREATE TABLE orbit (
    stadium INTEGER NOT NULL,
    cycle INTEGER NOT NULL,
    status TEXT NOT NULL,
    coordinates BLOB,
    length REAL,
    lyapunov REAL,
    margin REAL,
    residual REAL,
    error REAL,
    length_error REAL,
    lyapunov_error REAL,
    area REAL,
    area_error REAL,
    iterations INTEGER NOT NULL,
    solver TEXT NOT NULL,
    run INTEGER NOT NULL,
    PRIMARY KEY (stadium, cycle),
    CONSTRAINT fk_orbit_stadium FOREIGN KEY(stadium) REFERENCES stadium (id),
    CONSTRAINT fk_orbit_cycle FOREIGN KEY(cycle) REFERENCES cycle (id),
    CONSTRAINT fk_orbit_run FOREIGN KEY(run) REFERENCES run (id)
) WITHOUT ROWID, STRICT;

-- How far a period is filled at one value of a, the elapsed time, and the processor time of each stage, in
-- seconds. The counts are stored once the state is 'done'.
CREATE TABLE fill (
    stadium INTEGER NOT NULL,
    p INTEGER NOT NULL,
    state TEXT NOT NULL,
    cursor TEXT,
    seconds REAL NOT NULL,
    primitive INTEGER,
    rule_1 INTEGER,
    rule_2 INTEGER,
    rule_3 INTEGER,
    rule_4 INTEGER,
    rule_5 INTEGER,
    rule_6 INTEGER,
    n_t INTEGER,
    n_c INTEGER,
    classes INTEGER,
    boundary INTEGER,
    unresolved INTEGER,
    words INTEGER DEFAULT 0 NOT NULL,
    enumerating REAL DEFAULT 0 NOT NULL,
    solving REAL DEFAULT 0 NOT NULL,
    storing REAL DEFAULT 0 NOT NULL,
    PRIMARY KEY (stadium, p),
    CONSTRAINT fk_fill_stadium FOREIGN KEY(stadium) REFERENCES stadium (id)
) WITHOUT ROWID, STRICT;

-- A proof in ball arithmetic that a stored orbit exists: its true coordinates are within the radius of the
-- stored ones.
CREATE TABLE certificate (
    stadium INTEGER NOT NULL,
    cycle INTEGER NOT NULL,
    radius REAL NOT NULL,
    bits INTEGER NOT NULL,
    version TEXT NOT NULL,
    run INTEGER NOT NULL,
    PRIMARY KEY (stadium, cycle),
    CONSTRAINT fk_certificate_orbit FOREIGN KEY(stadium, cycle) REFERENCES orbit (stadium, cycle),
    CONSTRAINT fk_certificate_run FOREIGN KEY(run) REFERENCES run (id)
) WITHOUT ROWID, STRICT;

-- A value of a at which a class begins or ceases to be an orbit, numbered from 1 as a grows, and the bound on
-- its error. The given bounce of the least word, counted from 1, passes through the joint there; slope is
-- d slack / d ln a in radians. Changes of the same period with the same event have the same path at this a;
-- events are numbered once the period is complete. A class that is an orbit from a = 0 on has a birth at 0,
-- without a joint.
CREATE TABLE change (
    cycle INTEGER NOT NULL,
    number INTEGER NOT NULL,
    a REAL NOT NULL,
    error REAL NOT NULL,
    kind TEXT NOT NULL,
    bounce INTEGER,
    joint TEXT,
    event INTEGER,
    slope REAL,
    run INTEGER NOT NULL,
    PRIMARY KEY (cycle, number),
    CONSTRAINT fk_change_cycle FOREIGN KEY(cycle) REFERENCES cycle (id),
    CONSTRAINT fk_change_run FOREIGN KEY(run) REFERENCES run (id)
) WITHOUT ROWID, STRICT;

-- How far the changes of a period are stored. The counts are stored once the state is 'done'.
CREATE TABLE birth_fill (
    p INTEGER NOT NULL,
    state TEXT NOT NULL,
    cursor TEXT,
    seconds REAL NOT NULL,
    words INTEGER NOT NULL,
    classes INTEGER,
    births INTEGER,
    deaths INTEGER,
    always INTEGER,
    least REAL,
    largest REAL,
    PRIMARY KEY (p)
) WITHOUT ROWID, STRICT;

-- Averages over an ensemble of random trajectories, a reference for averages over orbits.
CREATE TABLE trajectory (
    id INTEGER NOT NULL,
    stadium INTEGER NOT NULL,
    bounces INTEGER NOT NULL,
    groups INTEGER NOT NULL,
    seed TEXT NOT NULL,
    lambda_d REAL NOT NULL,
    lambda_d_error REAL NOT NULL,
    lambda_c REAL NOT NULL,
    lambda_c_error REAL NOT NULL,
    mean_free_path REAL NOT NULL,
    mean_free_path_error REAL NOT NULL,
    run INTEGER NOT NULL,
    PRIMARY KEY (id),
    CONSTRAINT fk_trajectory_stadium FOREIGN KEY(stadium) REFERENCES stadium (id),
    CONSTRAINT fk_trajectory_run FOREIGN KEY(run) REFERENCES run (id)
) STRICT;

-- Bounds on the topological entropy at one value of a, proved with windows of up to this number of edges;
-- proof names the arithmetic that decided the windows. No orbits need to be stored at this a.
CREATE TABLE entropy_bound (
    a REAL NOT NULL,
    proof TEXT NOT NULL,
    edges INTEGER NOT NULL,
    lower REAL NOT NULL,
    upper REAL NOT NULL,
    windows INTEGER NOT NULL,
    undecided INTEGER NOT NULL,
    run INTEGER NOT NULL,
    PRIMARY KEY (a, proof, edges),
    CONSTRAINT fk_entropy_bound_run FOREIGN KEY(run) REFERENCES run (id)
) WITHOUT ROWID, STRICT;

-- A window low <= k < high in which all levels of one parity are stored at one value of a, the number of
-- levels below the window, and the processor time in seconds. Windows do not overlap.
CREATE TABLE level_fill (
    a REAL NOT NULL,
    parity TEXT NOT NULL,
    low REAL NOT NULL,
    high REAL NOT NULL,
    below INTEGER NOT NULL,
    seconds REAL NOT NULL,
    run INTEGER NOT NULL,
    PRIMARY KEY (a, parity, low),
    CONSTRAINT fk_level_fill_run FOREIGN KEY(run) REFERENCES run (id)
) WITHOUT ROWID, STRICT;

-- A level of one parity at one value of a, numbered from 1, with an estimate of its error. No orbits need to
-- be stored at this a.
CREATE TABLE level (
    a REAL NOT NULL,
    parity TEXT NOT NULL,
    number INTEGER NOT NULL,
    k REAL NOT NULL,
    error REAL NOT NULL,
    PRIMARY KEY (a, parity, number)
) WITHOUT ROWID, STRICT;

-- How far a period is swept at one value of a: the number of blocks, the counts so far, the elapsed time and
-- the processor time in seconds. The sums (orbitdb.averages.by_period) and the moments
-- (orbitdb.averages.tilting) are stored once the state is 'done'; until then, the moments are those of
-- no orbit.
CREATE TABLE sweep (
    stadium INTEGER NOT NULL,
    p INTEGER NOT NULL,
    state TEXT NOT NULL,
    cursor TEXT,
    blocks INTEGER NOT NULL,
    seconds REAL NOT NULL,
    processor REAL NOT NULL,
    words INTEGER NOT NULL,
    n_c INTEGER NOT NULL,
    classes INTEGER NOT NULL,
    boundary INTEGER NOT NULL,
    unresolved INTEGER NOT NULL,
    sums BLOB,
    moments BLOB NOT NULL,
    run INTEGER,
    PRIMARY KEY (stadium, p),
    CONSTRAINT fk_sweep_stadium FOREIGN KEY(stadium) REFERENCES stadium (id),
    CONSTRAINT fk_sweep_run FOREIGN KEY(run) REFERENCES run (id)
) WITHOUT ROWID, STRICT;

-- The sums of one block, numbered from 0, of a sweep that is not done.
CREATE TABLE sweep_block (
    stadium INTEGER NOT NULL,
    p INTEGER NOT NULL,
    number INTEGER NOT NULL,
    sums BLOB NOT NULL,
    moments BLOB NOT NULL,
    run INTEGER NOT NULL,
    PRIMARY KEY (stadium, p, number),
    CONSTRAINT fk_sweep_block_sweep FOREIGN KEY(stadium, p) REFERENCES sweep (stadium, p),
    CONSTRAINT fk_sweep_block_run FOREIGN KEY(run) REFERENCES run (id)
) WITHOUT ROWID, STRICT;
