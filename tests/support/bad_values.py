"""Bad option values, as typed by people, passed by programs or corrupted, and random SQL expressions."""

import random
from pathlib import Path

NUMBERS = [
    "0", "-1", "nan", "inf", "-inf", "1e-9", "1e9", "1e400", "½", "1,6", "", "abc", "1e-6", "0x10", "1_0",
    "٣", " 1.6", "--", "99999999999999999999", "5e-324", "\udcff", "\x00", "\x1b[31m", "1\n2",
]  # fmt: skip
INTEGERS = [
    "0", "-1", "1", "2-", "40", "1.5", "", "abc", "½", "1e3", "\udcff", "1_0", "99999999999999999999",
    "9" * 5000,
]  # fmt: skip
PERIODS = [
    "11", "2-8", "2,3,5-7", "8-2", "0", "1", "-1", "2-", "-8", "2--8", "40", "99999999999999999999",
    "1-999999999", "", "abc", ",", "2,", "½", " 3 ", "\udcff", ",".join(["2"] * 5000),
    ",".join(map(str, range(2, 8000, 2))),
]  # fmt: skip
CODES = [
    "17", "7", "", "1717", "13", "02", "131313", "(", "(1", "1)", "()", "1^", "^2", "1^0", "1^-1",
    "1^99999999", "1^1000001", "(" * 2000 + "1" + ")" * 2000, "1" * 100_000, "13" * 50_000, "0", "00", "x",
    "1\t3", "½", "٣", "1^٣", "\udcff", "\x00", "\x1b[31m13", "13\n13", "-", "--", "=13", "(1^9)^9 3", "6",
]  # fmt: skip
TEXTS = [
    "", "self", "pair", "Self", "\udcff", "\x00", "\x1b[31m", "'", "1", "x,T,xT", "T,x", "orbit", "all",
    "orbit,orbit", ",", "boundary", "½", "a" * 100_000, "lost", ",".join(["orbit"] * 50_000),
]  # fmt: skip
RANGES = [
    "length=3:10", "length=", "length", "=3", "length=3", "length=:", "length=nan:", "length=-inf:inf",
    "length=1e400:", "margin=:1e-4", "colour=1:2", "length=a:b", "length=3:10:5", "length=½:", "\udcff",
    "length=9:3", "length=:" + "9" * 5000,
]  # fmt: skip
EXPRESSIONS = [
    "1", "0", "p", "lambda_c < 0.5", "colour", "", "(", ")", "'", '"', "--", "/*", "1;", "1; DROP TABLE run",
    ":x", "?", "@x", "$x", "1 UNION SELECT 1", "\udcff", "\x00", "\x1b[31m = 1", "p IN (1, 2", "x'00'",
    "abs(-9223372036854775808)", "9223372036854775807 + 1", "1e400", "p COLLATE nocase", "p COLLATE other",
    "RAISE(ABORT, 'x')", "NULL", "p BETWEEN", "EXISTS (SELECT 1)", "count(*) > 1", "code MATCH 'x'",
    "code REGEXP 'x'", "code = '½'", "code = ':x'", "code LIKE '%' ESCAPE 'ab'", "p / 0", "1 -- )",
    "code = '$x^{'", "NOT " * 200 + "1", "(" * 50 + "1" + ")" * 50, "p = 1 OR " * 900 + "1",
    "p = 1 OR " * 3000 + "1", "- - - 5", "p << 70", "p -> 1", "random() % 2 = 0",
    "substr(code, -9223372036854775808, 9223372036854775807) = ''", "round(length, 99999999) > 1",
]  # fmt: skip
PARAMETERS = [
    "x=1", "x=", "=1", "x", "x=nan", "x=inf", "x=99999999999999999999", "x=" + "9" * 5000, "x=½", "x=\udcff",
    "1x=2", "x y=1", "é=1", "x=a=b",
]  # fmt: skip
COLUMNS = ["code", "length,p", "colour", "", ",", "code,", "code,code", "\udcff", "code;DROP", "*", " p , a ",
           ",".join(["code"] * 3000)]  # fmt: skip
ORDERS = ["p", "length desc", "-length", "colour", "", ",", "--length", "length;DROP", "\udcff", "1", "p,,p",
          "p desc desc", ",".join(["p"] * 3000)]  # fmt: skip
FORMATS = ["csv", "tsv", "json", "jsonl", "table", "xml", "", "CSV", "\udcff", "parquet", "npz"]


def paths(folder: Path, ending: str) -> list[str]:
    """Return names of files, some of which cannot be written."""
    names = [f"ok{ending}", ending, f"{'n' * 300}{ending}", f"missing/x{ending}", f"\udcff{ending}", "noext",
             f"file/x{ending}", f"new\nline{ending}", f"\x1b[31m{ending}", f"folder{ending}"]  # fmt: skip
    nowhere = ["", ".", "/", "/dev/full", "/dev/null", f"a\x00b{ending}"]
    return [str(folder / name) for name in names] + nowhere


def make_paths(folder: Path, ending: str) -> None:
    """Create the file and the folder that make some of the `paths` unusable."""
    (folder / "file").write_text("not a folder")
    (folder / f"folder{ending}").mkdir()


def databases(folder: Path) -> list[str]:
    """Create files that are not usable catalogues; return their names and other unusable names."""
    import os
    import sqlite3

    (folder / "text.db").write_text("hello\n" * 50)
    (folder / "short.db").write_bytes(b"SQLite format 3\x00")
    (folder / "loop.db").symlink_to(folder / "loop.db")
    os.mkfifo(folder / "fifo.db")
    other = sqlite3.connect(folder / "other.db")
    other.execute("CREATE TABLE t (x)")
    other.close()
    names = ["text.db", "short.db", "loop.db", "fifo.db", "other.db", "text.db/x", "missing.db", "n" * 300]
    return [str(folder / name) for name in names] + [str(folder), "", "/dev/full", "/dev/zero", "a\x00b"]


_NAMES = ["code", "p", "length", "lambda_c", "code", "status", "margin", "class_size", "rules", "a", "colour"]
_LITERALS = ["1", "0", "-1", "2.5", "1e3", "1e400", "'13'", "''", "'o''rbit'", "NULL", "x'00'", "'%0%'",
             "0x1F", "9223372036854775807", "'½'", "TRUE", '"p"', "[length]", "`word`"]  # fmt: skip
_BINARY = ["+", "-", "*", "/", "%", "||", "=", "<>", "<", ">=", "AND", "OR", "LIKE", "GLOB", "IS", "IS NOT",
           "<<", "&", "|", "->", "COLLATE", "MATCH"]  # fmt: skip
_FUNCTIONS = ["abs", "length", "round", "max", "min", "coalesce", "substr", "instr", "upper", "replace",
              "count", "sum", "iif", "typeof", "sqrt", "zeroblob", "printf", "load_extension",
              "random"]  # fmt: skip
_BROKEN = ["(", ")", "'", '"', ";", ",", "--", "/*", "*/", "?", ":x", "@y", "$z", "SELECT", "FROM", "WITH",
           "catalogue", "sqlite_master", "ORDER BY", "UNION", "\\", "\n", "½", "\udcff", ".",
           "DROP TABLE orbit", "ATTACH 'x' AS y", "PRAGMA", "VALUES", "json_each('[1]')",
           "RAISE(FAIL, 'x')"]  # fmt: skip


def expression(rng: random.Random, depth: int = 3) -> str:
    """Return a random SQL expression, mostly well formed, of columns, functions and subqueries."""
    if depth == 0 or rng.random() < 0.2:
        return rng.choice(_NAMES if rng.random() < 0.5 else _LITERALS)
    one, two = expression(rng, depth - 1), expression(rng, depth - 1)
    forms = [
        f"{one} {rng.choice(_BINARY)} {two}",
        f"({one})",
        f"NOT {one}",
        f"{rng.choice(_FUNCTIONS)}({one})",
        f"{rng.choice(_FUNCTIONS)}({one}, {two})",
        f"{one} BETWEEN {two} AND {rng.choice(_LITERALS)}",
        f"{one} IN ({two}, {rng.choice(_LITERALS)})",
        f"CASE WHEN {one} THEN {two} ELSE {rng.choice(_LITERALS)} END",
        f"CAST({one} AS {rng.choice(['TEXT', 'INTEGER', 'REAL', 'BLOB'])})",
        f"{one} < (SELECT max({two}) FROM catalogue AS b WHERE b.p = 3)",
        f"{rng.choice(_NAMES)} IN (SELECT {rng.choice(_NAMES)} FROM catalogue WHERE {one})",
        f"{one} IS NOT NULL",
    ]
    return rng.choice(forms)


def damaged(rng: random.Random) -> str:
    """Return an expression; one in three has something inserted or removed."""
    text = expression(rng)
    if rng.random() < 0.33:
        place = rng.randrange(len(text) + 1)
        if rng.random() < 0.7:
            return f"{text[:place]} {rng.choice(_BROKEN)} {text[place:]}"
        return text[:place] + text[place + rng.randrange(1, 6) :]
    return text
