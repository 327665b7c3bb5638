"""Commands refuse bad input in one line that says what is wrong and what to do. Nothing changes."""

import io
import shlex

import pytest

REFUSED = """
nonsense | 2 | nonsense
table --reversal self | 2 | No such option: --reversal
query --reversal self | 2 | --reversal (it is now --time-reversal)
query 13 --bounces | 2 | --bounces (it is now --by-bounce)
query -P x=1 | 2 | -P (it is now --parameter)
query -format csv | 2 | options have two dashes: --format (
query -k 3 | 2 | No such option: -k
levels -k 0:3 | 2 | options have two dashes: --k (
fill 8 | 2 | periods are given with --p: fill --p 8 (
fill 1232131 | 2 | words are given with --code: fill --code 1232131 (
query --columms code | 2 | did you mean --columns?
colums | 2 | colums | columns
--versio | 2 | --versio | --version
table --colour | 2 | --colour | --help
--db x.db table | 2 | --db | after the command | orbitdb table --db PATH
fill --p 2 --p 3 | 2 | --p is given 2 times: give it once (
simulate --a 1 --a=2 | 2 | --a is given 2 times: give it once (
query --p 3 --p 4 | 2 | --p is given 2 times: give it once (

query --code 1717 | 2 | '7' at position 2
query --code 1^ | 2 | needs a number
query '1(02)^2999999' | 2 | the power ^2999999 at position 6
fill --p 4 --scheduler nowhere.json | 2 | there is no file nowhere.json | tcp://host:8786
query --code 13 --a 0 | 2 | half length
query --p 2-1 | 2 | backwards: the least period is 2
query --status lost | 2 | lost
query --range colour=1:2 | 2 | colour
query --range length=long: | 2 | length=3:10
query --where 'p = :x' --parameter =3 | 2 | name=value
query 13 --p 3 | 2 | --p | --code
entropy --status dynamical | 2 | only orbits (and boundary) have | : leave out status dynamical
plot lengths --status all -o x.svg | 2 | only orbits (and boundary) have
lyapunov --status all | 2 | only orbits (and boundary) have | : leave out status geometric
lyapunov --weight x | 2 | 'x' | exp | det
lyapunov --cut nan | 2 | cut nan | 1000

query --code 13 --where 'p > 2' | 2 | --where | --code
query --code 13 --p 3 --order p --limit 3 --offset 1 | 2 | --p, --order, --limit, --offset | --code | them
query --code 13 --parameter x=1 | 2 | --parameter | --code
query --parameter x=1 | 2 | --parameter | --where
query --where '1; DELETE FROM orbit' | 2 | 1; DELETE FROM orbit
query --order 'p; DROP TABLE run' | 2 | p; DROP TABLE run | write columns
query -c '(SELECT 1)' | 2 | (SELECT 1)
query -c '*' | 2 | '*'
query -c code,p,code | 2 | 'code' | twice
query --where 'p > 2' --parameter x=1 | 2 | 'p > 2' | :x
fill --p 3 --code 13 | 2 | --p | --code
fill --code 1 | 2 | 1 has one symbol | longer
fill --code 13 --from 2 --jobs 2 --geometric | 2 | --geometric, --jobs | --code | them
plot orbit --code 13 --p 3 -o x.svg | 2 | --p | plot orbit
plot entropy --code 13 -o x.svg | 2 | --code | plot entropy
plot births 13 -o x.svg | 2 | WORD | plot births
plot sheet 13 --p 3 -o x.svg | 2 | --p | with words
plot orbit 13 --size 0x5 -o x.svg | 2 | --size | inches
plot orbit 13 --a 1:2:3 -o x.svg | 2 | draws one a
plot lengths --order length -o x.svg | 2 | --order | plot lengths
bench --kind stress --a 2 --p 3 | 2 | --a, --p | --kind stress
browse --code 19 | 2 | symbol '9' at position 2

query --a 1_6 | 2 | 1_6
query --limit -1 | 2 | -1
query --range length=9:5 | 2 | 9:5
query --p ٣ | 2 | ٣
fill --p 1_1 | 2 | 1_1
simulate --bounces 1e-1 | 2 | 1e-1
verify --restarts 1e9 | 2 | --restarts
fill --p 3 --jobs 0 | 2 | '--jobs': 0 is less than 1

delete --a 1.6 --p 40 --yes | 1 | nothing of period 40 is stored at a = 1.6 in
query --db '' | 2 | '--db': the path is empty: name a file
export '' | 2 | '[FILE]': the path is empty
plot orbit 13 -o '' | 2 | '--output' / '-o': the path is empty
identify --points '' | 2 | '--points': the path is empty
assess '' | 2 | 'FILE': the path is empty
spectrum --levels '' | 2 | '--levels': the path is empty
verify '' | 2 | 'FOLDER': the path is empty
bench -o '' | 2 | '--output' / '-o': the path is empty

table --a all --a 1 | 2 | --a all
query --a 1 --a x | 2 | --a | 'x' is not a number
entropy --a 1:2 | 2 | --a | FROM:TO:COUNT
lyapunov --a 0 | 2 | --a | not a half length
levels --k 5 | 2 | '5': give FROM:TO
levels --k 5:1 | 2 | 0:30
levels --k 0:5 --parity xx | 2 | ee, eo, oe or oo
levels --k 0:5 --a 50 | 2 | 0.05 to 20
levels --k 0:5000 | 2 | too many
spectrum --levels nowhere | 2 | nowhere: No such file or directory; give a file

plot orbit -o x.svg | 2 | plot orbit 1232131
plot orbit --code 001 -o x.svg | 2 | geometrically pruned
plot life 0011 -o x.svg | 2 | 0011 is not an orbit at any a
plot life 13 113 -o x.svg | 2 | name one orbit to draw: plot life
query --status geometric --p 4 | 1 | (there are 283): 'orbitdb fill --p 4 --from 4 --geometric' stores them
query --status geometric --p 4-5 | 1 | of periods 4-5 are not stored (there are 1,741): 'orbitdb
export x.csv --status geometric --p 4 | 1 | of period 4 are not stored (there are 283)
plot sheet --status geometric --p 4 -o x.svg | 1 | of period 4 are not stored (there are 283)
plot sheet --status dynamical --p 6 -o x.svg | 1 | 64 dynamically pruned words of | : no path to draw
plot phase-space --status dynamical --p 6 -o x.svg | 1 | : no path to draw; --status orbit
plot phase-space --p 77 -o x.svg | 1 | no period above 20 is filled at a = 1.6 (filled: periods 2-6
plot phase-space --p 6 --range length=99: -o x.svg | 1 | nothing to draw
plot entropy --a 0.7 -o x.svg | 1 | nothing is filled at a = 0.7
plot entropy -o x.gif | 2 | end the name in .png, .svg, .pdf
plot entropy -o - | 2 | --format
plot entropy -o x.pdf --format svg | 2 | leave one of them out
plot orbit --code 13 -o nowhere/x.pdf | 3 | no folder nowhere
plot orbit --code 13 -o /proc/x.svg | 3 | /proc/x.svg cannot be written
plot lyapunov -o x.svg --status orbit,unresolved | 2 | leave out status unresolved

export x.xlsx | 2 | xlsx
export orbits | 2 | --format
export - | 2 | name a file
export x --dataset --format csv | 2 | --format does nothing with --dataset
export z.json --format csv | 2 | z.json ends in .json, but --format says csv: leave one
export orbits.csv -c colour | 2 | colour
fill --p 3 --db nowhere/new.db | 3 | no folder nowhere
fill --p 3 --db orbits.db/new.db | 3 | no folder orbits.db
simulate --db nowhere/such/new.db | 3 | no folder nowhere/such
export nowhere/orbits.json | 3 | no folder nowhere
table --a all --db new.db | 3 | no catalogue at new.db | orbitdb fill
query 13 --a all --db new.db | 3 | no catalogue at new.db | orbitdb fill
export x.csv --status dynamical --p 5 --by-bounce | 1 | these words have no bounces; only orbits do
export x.csv --p 2-5 --order status --limit 1 --by-bounce | 1 | these words have no bounces
export x.csv --p 3 --limit 0 | 2 | 0 is less than 1
export x.csv --status orbit --where p=1 --by-bounce | 1 | no orbits at a = 1.6 where p=1: nothing is written

sweep --db new.db --p 21 | 2 | 21
sweep --db new.db --p 3 --time-reversal self | 2 | No such option: --time-reversal

identify --start 0,0 | 2 | three numbers
identify --start 0,0,½ | 2 | '½' is not a number
identify --points - --bounces 5 | 2 | --bounces does nothing with --points
identify --points nowhere | 2 | nowhere cannot be read
identify --points - | 2 | no points
identify --points /dev/zero | 2 | more than 1000000 characters

sql "SELECT * FROM pragma_table_info('orbit')" | 2 | it may only read, with a single SELECT
sql 'SELECT 1; DELETE FROM orbit' | 2 | one statement
sql 'DELETE FROM orbit' | 2 | it may only read, with a single SELECT
sql '' | 2 | write a single SELECT
sql 'SELECT p, p FROM catalogue' | 2 | column 'p' occurs twice
sql 'SELECT code FROM life' | 2 | no such column: code; only catalogue has it;
sql 'SELECT colour FROM catalogue' | 2 | no such column: colour; 'orbitdb columns' lists all columns
sql 'SELECT c.lenght FROM catalogue c' | 2 | no such column: c.lenght; did you mean length?
sql 'SELECT * FROM catalog' | 2 | no such table: catalog: did you mean catalogue?
sql 'SELECT :x' | 2 | --parameter name=value
sql 'SELECT :x AS x' --parameter x=1 --parameter y=2 --parameter z=3 | 2 | no :y, :z: leave out its value
sql SELECT | 2 | incomplete input
sql LONG | 2 | Expression tree is too large
sql DIGITS | 2 | syntax error
"""
"""A command, its exit code, and parts of its message."""


LONG = f"'SELECT {'1 + ' * 5000}1'"
"""A statement of 20008 characters."""

BLOCKS = [block.splitlines() for block in REFUSED.strip().split("\n\n")]


@pytest.mark.parametrize("block", BLOCKS, ids=lambda block: block[0].partition(" | ")[0])
def test_a_refusal_is_one_line_and_changes_nothing(own, tmp_path, cli, monkeypatch, block):
    monkeypatch.chdir(tmp_path)
    monkeypatch.setattr("sys.stdin", io.StringIO())
    before = own.read_bytes()
    for line in block:
        command, code, *pieces = line.split(" | ")
        done = cli(*shlex.split(command.replace("LONG", LONG).replace("DIGITS", 25_000 * "0123")))
        assert done.says(int(code), "" if code == "1" else "orbitdb: ", *pieces), (command, done)
        assert own.read_bytes() == before, command
    assert {path.name.partition("-")[0] for path in tmp_path.iterdir()} == {own.name}  # and its journal
