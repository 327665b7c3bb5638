"""Mutants: the code with one small mistake each, as a person might make it."""

import ast
import copy
import hashlib
from collections.abc import Iterable, Iterator, Sequence
from dataclasses import dataclass

_BORDERS = {ast.Lt: ast.LtE, ast.LtE: ast.Lt, ast.Gt: ast.GtE, ast.GtE: ast.Gt}
_OPPOSITES = {
    ast.Lt: ast.GtE, ast.GtE: ast.Lt, ast.Gt: ast.LtE, ast.LtE: ast.Gt, ast.Eq: ast.NotEq, ast.NotEq: ast.Eq,
    ast.Is: ast.IsNot, ast.IsNot: ast.Is, ast.In: ast.NotIn, ast.NotIn: ast.In,
}  # fmt: skip
_OTHERS = {
    ast.Add: ast.Sub, ast.Sub: ast.Add, ast.Mult: ast.Div, ast.Div: ast.Mult, ast.FloorDiv: ast.Mult,
    ast.Mod: ast.Mult, ast.Pow: ast.Mult, ast.BitAnd: ast.BitOr, ast.BitOr: ast.BitAnd,
    ast.BitXor: ast.BitAnd, ast.LShift: ast.RShift, ast.RShift: ast.LShift,
}  # fmt: skip
_COMMUTATIVE = {"min", "max", "minimum", "maximum", "hypot", "gcd", "fmin", "fmax"}
_WORDS = {"help", "metavar", "epilog", "rich_help_panel", "description"}
_LONG = 6
"""Longer tuples and lists are tables, whose neighbours are not exchanged."""

_Change = tuple[str, ast.expr | ast.stmt, ast.AST | str]
"""The kind of a mistake, the replaced node, and its replacement."""


@dataclass(frozen=True)
class Mutant:
    """One mistake in one file.

    Attributes
    ----------
    path : str
        The file, relative to the root of the tree.
    kind : str
        The kind of mistake.
    start, end : int
        The range of bytes replaced.
    text : str
        Their replacement.
    first, last : int
        Lines of the statement, or of the function if its head is altered. Tests that run them may notice.
    names : tuple of str
        The names a statement outside functions binds; it runs at import, outside any test.
    """

    path: str
    kind: str
    start: int
    end: int
    text: str
    first: int
    last: int
    names: tuple[str, ...]

    def applied(self, source: str) -> str:
        """Return the file with the mistake."""
        raw = source.encode()
        return (raw[: self.start] + self.text.encode() + raw[self.end :]).decode()

    def shown(self, source: str) -> tuple[str, str]:
        """Return the altered lines, before and after."""
        raw = source.encode()
        start = raw.rfind(b"\n", 0, self.start) + 1
        end = raw.find(b"\n", self.end) % (len(raw) + 1)
        after = raw[start : self.start] + self.text.encode() + raw[self.end : end]
        return _dedented(raw[start:end].decode()), _dedented(after.decode())

    def rank(self, source: str, seed: int) -> bytes:
        """Return the sort key in a sample, independent of changes elsewhere in the tree."""
        told = (seed, self.path, self.kind, self.text, *self.shown(source))
        return hashlib.sha256(repr(told).encode()).digest()


def mutants(path: str, source: str) -> list[Mutant]:
    """Return all mutants of a file; some may be equivalent code (see `differs`)."""
    tree, begins, found = ast.parse(source), [0], []
    for line in source.encode().splitlines(keepends=True):
        begins.append(begins[-1] + len(line))
    for node, span, names in _places(tree, (1, 1), ()):
        for kind, old, new in _changes(node):
            text = new if isinstance(new, str) else ast.unparse(ast.fix_missing_locations(new))
            if isinstance(new, ast.expr):
                text = f"({text})"
            start = begins[old.lineno - 1] + old.col_offset
            end = begins[(old.end_lineno or 0) - 1] + (old.end_col_offset or 0)
            found.append(Mutant(path, kind, start, end, text, *span, names or ()))
    return found


def differs(mutant: Mutant, source: str) -> bool:
    """Tell whether a mutant is valid and different code."""
    try:
        return ast.dump(ast.parse(mutant.applied(source))) != ast.dump(ast.parse(source))
    except SyntaxError:
        return False


def _dedented(text: str) -> str:
    return " ".join(line.strip() for line in text.splitlines())


def _places(
    node: ast.AST, span: tuple[int, int], names: tuple[str, ...] | None
) -> Iterator[tuple[ast.AST, tuple[int, int], tuple[str, ...] | None]]:
    """Yield each node that may be altered, the lines of its statement, and the names bound outside functions.

    Docstrings, annotations, assertions, messages and ``__repr__`` are left out.
    """
    inner = names
    match node:
        case ast.FunctionDef(name="__repr__") | ast.Assert():
            return
        case ast.If(test=test) if "TYPE_CHECKING" in ast.unparse(test):
            return
        case ast.FunctionDef(name=name) | ast.AsyncFunctionDef(name=name):
            span, names, inner = (
                (node.lineno, node.end_lineno or 0),
                (name,) if names is not None else None,
                None,
            )
        case ast.ClassDef(name=name):
            inner = (name,)
        case ast.Assign() | ast.AnnAssign() if names is not None:
            targets = node.targets if isinstance(node, ast.Assign) else [node.target]
            inner = (*names, *(n.id for each in targets for n in ast.walk(each) if isinstance(n, ast.Name)))
            if inner == ("__all__",):
                return
    if isinstance(node, ast.stmt) and not isinstance(node, ast.FunctionDef | ast.AsyncFunctionDef):
        body = getattr(node, "body", None)
        last = max(node.lineno, body[0].lineno - 1) if body else node.end_lineno
        span = (node.lineno, last or node.lineno)
    yield node, span, inner
    for child in _children(node):
        of_head = isinstance(node, ast.FunctionDef | ast.AsyncFunctionDef) and isinstance(child, ast.expr)
        yield from _places(child, span, names if of_head else inner)


def _children(node: ast.AST) -> Iterable[ast.AST]:
    match node:
        case ast.FunctionDef() | ast.AsyncFunctionDef():
            defaults = (*node.args.defaults, *node.args.kw_defaults)
            return [*(each for each in defaults if each is not None), *node.body]
        case ast.ClassDef() | ast.ExceptHandler():  # the order of its types makes no difference
            return node.body
        case ast.Assign() | ast.AugAssign() | ast.AnnAssign():
            return [node.value] if node.value is not None else []
        case ast.Raise() | ast.JoinedStr():  # before Python 3.12 nodes in f-strings have no positions
            return []
        case ast.comprehension():
            return [node.iter, *node.ifs]
        case ast.keyword() if _asserts(node):
            return []
        case ast.Compare():  # the order of members makes no difference
            return [
                part
                for op, side in zip([None, *node.ops], [node.left, *node.comparators], strict=True)
                for part in _compared(op, side)
            ]
        case ast.BinOp() if any(map(_is_text, (node.left, node.right))):
            return []
        case ast.Call() if _name(node) == "TypeVar":
            return []
    return ast.iter_child_nodes(node)


def _changes(node: ast.AST) -> Iterator[_Change]:
    """Yield the possible mistakes at a node."""
    if isinstance(node, ast.stmt):
        yield from _of_statement(node)
    match node:
        case ast.If(test=test) | ast.While(test=test) | ast.IfExp(test=test) if not _is_one_comparison(test):
            yield "negated", test, ast.UnaryOp(ast.Not(), test)
        case ast.Return(value=ast.BoolOp() as value):
            yield "negated", value, ast.UnaryOp(ast.Not(), value)
        case ast.comprehension():
            yield from (("condition dropped", test, "True") for test in node.ifs)
        case ast.Compare():
            for k, operator in enumerate(node.ops):
                for table, kind in ((_BORDERS, "border"), (_OPPOSITES, "comparison")):
                    if type(operator) in table:
                        turned = [*node.ops[:k], table[type(operator)](), *node.ops[k + 1 :]]
                        yield kind, node, _with(node, ops=turned)
        case ast.BoolOp():
            yield "and or", node, _with(node, op=ast.Or() if isinstance(node.op, ast.And) else ast.And())
            for k in range(len(node.values)):
                rest = [*node.values[:k], *node.values[k + 1 :]]
                yield "operand dropped", node, rest[0] if len(rest) == 1 else ast.BoolOp(node.op, rest)
        case ast.BinOp() if not any(map(_is_text, (node.left, node.right))):
            if isinstance(node.op, ast.MatMult):
                yield "operands swapped", node, _with(node, left=node.right, right=node.left)
            if type(node.op) in _OTHERS:
                yield "operator", node, _with(node, op=_OTHERS[type(node.op)]())
                yield from (("operand dropped", node, side) for side in (node.left, node.right))
        case ast.UnaryOp():
            yield "sign", node, node.operand
        case ast.Constant():
            yield from (("constant", node, other) for other in _other_values(node.value))
        case ast.Call() if _name(node) != "TypeVar":
            if _name(node) not in _COMMUTATIVE:
                yield from (("arguments swapped", node, _with(node, args=a)) for a in _exchanged(node.args))
            for k, keyword in enumerate(node.keywords):
                if keyword.arg is not None and keyword.arg not in _WORDS and not _asserts(keyword):
                    fewer = [*node.keywords[:k], *node.keywords[k + 1 :]]
                    yield "argument dropped", node, _with(node, keywords=fewer)
        case ast.Tuple(ctx=ast.Load()) | ast.List(ctx=ast.Load()) if len(node.elts) <= _LONG:
            yield from (("values swapped", node, _with(node, elts=items)) for items in _exchanged(node.elts))
        case ast.Dict():
            yield from (("values swapped", node, _with(node, values=v)) for v in _exchanged(node.values))


def _of_statement(node: ast.stmt) -> Iterator[_Change]:
    match node:
        case ast.Break():
            yield "loop", node, "continue"
        case ast.Continue():
            yield "loop", node, "break"
        case ast.AugAssign() if type(node.op) in _OTHERS:
            yield "operator", node, _with(node, op=_OTHERS[type(node.op)]())
    match node:
        case (
            ast.Raise() | ast.Continue() | ast.AugAssign() | ast.Return(value=None)
            | ast.Expr(value=ast.Call() | ast.Await(value=ast.Call()))
        ):  # fmt: skip
            yield "statement dropped", node, "pass"
        case ast.Assign() if any(isinstance(each, ast.Attribute | ast.Subscript) for each in node.targets):
            yield "statement dropped", node, "pass"


def _other_values(value: object) -> list[str]:
    match value:
        case bool():
            return [repr(not value)]
        case int():
            return [repr(value + 1)]
        case float():
            return [repr(2 * value), repr(value / 2)] if value else ["1.0"]
    return []


def _with(node: ast.AST, **fields: object) -> ast.AST:
    """Return a copy of a node with some fields replaced."""
    new = copy.copy(node)
    for name, value in fields.items():
        setattr(new, name, value)
    return new


def _exchanged(items: Sequence[ast.expr]) -> Iterator[list[ast.expr]]:
    """Yield the list with each pair of neighbours exchanged."""
    for k in range(len(items) - 1):
        one, two = items[k : k + 2]
        if not isinstance(one, ast.Starred) and not isinstance(two, ast.Starred) and not _same(one, two):
            yield [*items[:k], two, one, *items[k + 2 :]]


def _same(one: ast.AST, two: ast.AST) -> bool:
    return ast.dump(one) == ast.dump(two)


def _is_one_comparison(test: ast.expr) -> bool:
    """Tell whether another mistake already negates a condition."""
    if isinstance(test, ast.UnaryOp):
        return isinstance(test.op, ast.Not)
    return isinstance(test, ast.Compare) and len(test.ops) == 1


def _compared(operator: ast.cmpop | None, side: ast.expr) -> list[ast.expr]:
    if isinstance(operator, ast.In | ast.NotIn) and isinstance(side, ast.Tuple | ast.List):
        return side.elts
    return [side]


def _is_text(node: ast.expr) -> bool:
    return isinstance(node, ast.JoinedStr) or (
        isinstance(node, ast.Constant) and isinstance(node.value, str | bytes)
    )


def _name(node: ast.Call) -> str:
    return getattr(node.func, "id", getattr(node.func, "attr", ""))


def _asserts(keyword: ast.keyword) -> bool:
    """Tell whether an argument only asserts something, so that correct code does not depend on it."""
    return keyword.arg == "strict" and isinstance(keyword.value, ast.Constant)
