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

CREATE TABLE cycle (
    id INTEGER NOT NULL,
    p INTEGER NOT NULL,
    word TEXT NOT NULL,
    class_size INTEGER NOT NULL,
    walls INTEGER NOT NULL,
    time_reversal TEXT NOT NULL,
    symmetry TEXT NOT NULL,
    PRIMARY KEY (id),
    CONSTRAINT uq_cycle_p UNIQUE (p, word)
) STRICT;

CREATE TABLE run (
    id INTEGER NOT NULL,
    started TEXT NOT NULL,
    version TEXT NOT NULL,
    parameters TEXT NOT NULL,
    PRIMARY KEY (id)
) STRICT;

CREATE TABLE stadium (
    id INTEGER NOT NULL,
    a REAL NOT NULL,
    PRIMARY KEY (id),
    CONSTRAINT uq_stadium_a UNIQUE (a)
) STRICT;

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

CREATE TABLE fill (
    stadium INTEGER NOT NULL,
    p INTEGER NOT NULL,
    state TEXT NOT NULL,
    cursor TEXT,
    seconds REAL NOT NULL,
    primitive INTEGER,
    rule_1 INTEGER, rule_2 INTEGER, rule_3 INTEGER, rule_4 INTEGER, rule_5 INTEGER, rule_6 INTEGER,
    n_t INTEGER,
    n_c INTEGER,
    classes INTEGER,
    boundary INTEGER,
    unresolved INTEGER,
    words INTEGER DEFAULT '0' NOT NULL,
    enumerating REAL DEFAULT '0' NOT NULL,
    solving REAL DEFAULT '0' NOT NULL,
    storing REAL DEFAULT '0' NOT NULL,
    PRIMARY KEY (stadium, p),
    CONSTRAINT fk_fill_stadium FOREIGN KEY(stadium) REFERENCES stadium (id)
) WITHOUT ROWID, STRICT;

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

CREATE TABLE sequence (
    p INTEGER NOT NULL,
    word TEXT NOT NULL,
    cycle INTEGER,
    element INTEGER,
    rules TEXT,
    PRIMARY KEY (p, word),
    CONSTRAINT fk_sequence_cycle FOREIGN KEY(cycle) REFERENCES cycle (id)
) WITHOUT ROWID, STRICT;

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

CREATE VIEW catalogue AS
SELECT stadium.a AS a, sequence.p AS p, sequence.word AS code, sequence.word AS word,
       cycle.word AS representative, coalesce(orbit.status, 'geometric') AS status,
       sequence.rules AS rules, orbit.length AS length, orbit.lyapunov AS lyapunov,
       orbit.lyapunov / sequence.p AS lambda_d, orbit.lyapunov / orbit.length AS lambda_c,
       cycle.time_reversal AS time_reversal, cycle.symmetry AS symmetry,
       cycle.class_size AS class_size, cycle.walls AS walls, orbit.margin AS margin,
       orbit.residual AS residual, orbit.error AS error, orbit.length_error AS length_error,
       orbit.lyapunov_error AS lyapunov_error, orbit.iterations AS iterations, orbit.solver AS solver,
       sequence.element AS element, sequence.cycle AS cycle,
       (SELECT nullif(change.a, 0.0) FROM change
        WHERE change.cycle = sequence.cycle AND change.number = 1) AS born,
       (SELECT change.a FROM change
        WHERE change.cycle = sequence.cycle AND change.number = 2) AS dies
FROM sequence
JOIN stadium
LEFT JOIN cycle ON cycle.id = sequence.cycle
LEFT JOIN orbit ON orbit.stadium = stadium.id AND orbit.cycle = sequence.cycle
WHERE orbit.status IS NOT NULL OR sequence.rules IS NOT NULL;

CREATE VIEW life AS
SELECT change.cycle AS cycle,
       cycle.p AS p,
       cycle.class_size AS class_size,
       cycle.word AS word,
       change.a AS born,
       change.error AS born_error,
       death.a AS dies,
       death.error AS dies_error
FROM change
JOIN cycle ON cycle.id = change.cycle
LEFT JOIN change AS death ON death.cycle = change.cycle AND death.number = change.number + 1
WHERE change.kind = 'born';
