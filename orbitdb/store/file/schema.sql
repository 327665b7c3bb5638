-- The tables of a catalogue (orbitdb/store/file/schema.py): every table, those first that others refer to.

-- The half lengths a that something is stored of.
CREATE TABLE stadium (
    id INTEGER NOT NULL,
    a REAL NOT NULL,
    PRIMARY KEY (id),
    CONSTRAINT uq_stadium_a UNIQUE (a)
) STRICT;

-- Who wrote a row: the program's version, its parameters as JSON, and when (UTC).
CREATE TABLE run (
    id INTEGER NOT NULL,
    started TEXT NOT NULL,
    version TEXT NOT NULL,
    parameters TEXT NOT NULL,
    PRIMARY KEY (id)
) STRICT;

-- One symmetry class: its least word, how many words it has, its straight bounces (walls), and all its words
-- one after another, p symbols each, in the order of the elements that lead to them: the first is the least
-- word. The id is the key of the least word (orbitdb.symbols.words.key); those of longer words count up from
-- LONG.
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

-- Which element leads to the n-th word of a class with this symmetry, counted from 0; the same rows in every
-- file.
CREATE TABLE element (
    symmetry TEXT NOT NULL,
    n INTEGER NOT NULL,
    element INTEGER NOT NULL,
    PRIMARY KEY (symmetry, n)
) WITHOUT ROWID, STRICT;

-- Words that break geometric rules, as least rotations (fill --geometric). They have no class; the id is
-- minus the key of the word, and for longer words counts down from -LONG.
CREATE TABLE pruned (
    id INTEGER NOT NULL,
    p INTEGER NOT NULL,
    word TEXT NOT NULL,
    rules TEXT NOT NULL,
    PRIMARY KEY (id),
    CONSTRAINT uq_pruned_p UNIQUE (p, word)
) STRICT;

-- What became of a class at one a; the coordinates are those of the least word, little-endian float64.
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
    iterations INTEGER NOT NULL,
    solver TEXT NOT NULL,
    run INTEGER NOT NULL,
    PRIMARY KEY (stadium, cycle),
    CONSTRAINT fk_orbit_stadium FOREIGN KEY(stadium) REFERENCES stadium (id),
    CONSTRAINT fk_orbit_cycle FOREIGN KEY(cycle) REFERENCES cycle (id),
    CONSTRAINT fk_orbit_run FOREIGN KEY(run) REFERENCES run (id)
) WITHOUT ROWID, STRICT;

-- How far a period is filled at one a, and what it took: seconds as they passed, and seconds of processors
-- by stage. The counts are there once the state is 'done'.
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

-- A proof by ball arithmetic that a stored orbit exists: its coordinates lie within the radius.
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

-- A value of a at which a class begins or ceases to be an orbit, counted from 1 as a grows, and the bound on
-- its error. The bounce of the least word, counted from 1, comes through the joint; slope is d slack / d ln
-- a in radians. Changes of one period with one event are one path at this a; events are numbered when the
-- whole period is there. A class that is an orbit from a = 0 on is born there, and nothing is said of a
-- joint.
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

-- How far the changes of a period are stored; the counts are there once the state is 'done'.
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

-- An ensemble of random trajectories: the reference beside averages over orbits.
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

-- What windows of up to so many edges prove of the topological entropy at one a, which need not be a stadium
-- with orbits; proof says what decided the windows.
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

-- A window of k in which all levels of one parity at one a are stored, low <= k < high, the number of levels
-- below it, and the seconds of processors that it took. Windows do not overlap.
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

-- A level of a parity at one a, counted from 1, and the estimate of its error; a need not be a stadium with
-- orbits.
CREATE TABLE level (
    a REAL NOT NULL,
    parity TEXT NOT NULL,
    number INTEGER NOT NULL,
    k REAL NOT NULL,
    error REAL NOT NULL,
    PRIMARY KEY (a, parity, number)
) WITHOUT ROWID, STRICT;

-- How far a period is swept at one a, and what was counted on the way, in so many blocks; the seconds are as
-- they passed, and of the processors that solved. The sums (orbitdb.averages.fixed_points) are there once the
-- state is 'done', as the moments are (orbitdb.averages.tilt_moments), which begin as those of no orbit. All
-- of it is of the subset that the canonical text selection names (orbitdb.store.asking.sweepable), empty for
-- all orbits.
CREATE TABLE sweep (
    stadium INTEGER NOT NULL,
    p INTEGER NOT NULL,
    selection TEXT NOT NULL,
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
    PRIMARY KEY (stadium, p, selection),
    CONSTRAINT fk_sweep_stadium FOREIGN KEY(stadium) REFERENCES stadium (id),
    CONSTRAINT fk_sweep_run FOREIGN KEY(run) REFERENCES run (id)
) WITHOUT ROWID, STRICT;

-- The sums of a block of a sweep that is not done, counted from 0.
CREATE TABLE sweep_block (
    stadium INTEGER NOT NULL,
    p INTEGER NOT NULL,
    selection TEXT NOT NULL,
    number INTEGER NOT NULL,
    sums BLOB NOT NULL,
    moments BLOB NOT NULL,
    run INTEGER NOT NULL,
    PRIMARY KEY (stadium, p, selection, number),
    CONSTRAINT fk_sweep_block_sweep FOREIGN KEY(stadium, p, selection)
        REFERENCES sweep (stadium, p, selection),
    CONSTRAINT fk_sweep_block_run FOREIGN KEY(run) REFERENCES run (id)
) WITHOUT ROWID, STRICT;
