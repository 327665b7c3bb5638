"""Mutants: the code with one small mistake each, as a hand would make it."""

import ast
import copy
import hashlib
from collections.abc import Iterator, Sequence
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
"""Displays of more elements are tables, of which no two neighbours are exchanged."""


@dataclass(frozen=True)
class Mutant:
    """One mistake in one file.

    Attributes
    ----------
    path : str
        The file, as seen from the root of the tree.
    kind : str
        What was done.
    start, end : int
        The bytes that are replaced.
    text : str
        What they are replaced by.
    first, last : int
        Lines of the statement; of a function's head, all lines of the function. Who executes them may notice.
    names : tuple of str
        What a statement outside of functions binds: it is executed at import, by nobody in particular.
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

    def line(self, source: str) -> int:
        """Return the line of the mistake."""
        return source.encode()[: self.start].count(b"\n") + 1

    def shown(self, source: str) -> tuple[str, str]:
        """Return the lines that it changes, before and after."""
        raw = source.encode()
        start = raw.rfind(b"\n", 0, self.start) + 1
        end = raw.find(b"\n", self.end) % (len(raw) + 1)
        after = raw[start : self.start] + self.text.encode() + raw[self.end : end]
        return _dedented(raw[start:end].decode()), _dedented(after.decode())

    def rank(self, source: str, seed: int) -> bytes:
        """Return where it stands in a sample: the same whatever is changed elsewhere in the tree."""
        told = (seed, self.path, self.kind, self.text, *self.shown(source))
        return hashlib.sha256(repr(told).encode()).digest()


def mutants(path: str, source: str) -> list[Mutant]:
    """Return all mutants of a file; some may be the same code in other words (see `differs`)."""
    finder = _Finder(path, source)
    finder.visit(ast.parse(source))
    return finder.found


def differs(mutant: Mutant, source: str) -> bool:
    """Tell whether a mutant is other code, and code at all."""
    try:
        return ast.dump(ast.parse(mutant.applied(source))) != ast.dump(ast.parse(source))
    except SyntaxError:
        return False


def _dedented(text: str) -> str:
    return " ".join(line.strip() for line in text.splitlines())


def _same(first: ast.AST, second: ast.AST) -> bool:
    return ast.dump(first) == ast.dump(second)


def _exchanged(items: Sequence[ast.expr]) -> Iterator[list[ast.expr]]:
    """Give a list with each two neighbours exchanged in turn."""
    for k in range(len(items) - 1):
        pair = items[k : k + 2]
        if not any(isinstance(item, ast.Starred) for item in pair) and not _same(*pair):
            yield [*items[:k], pair[1], pair[0], *items[k + 2 :]]


class _Finder(ast.NodeVisitor):
    """Walks through a file; docstrings, annotations, assertions, messages and ``__repr__`` are left out."""

    def __init__(self, path: str, source: str) -> None:
        self.path = path
        self.found: list[Mutant] = []
        self._lines = [0]
        for line in source.encode().splitlines(keepends=True):
            self._lines.append(self._lines[-1] + len(line))
        self._span = (1, 1)
        self._names: tuple[str, ...] = ()
        self._inside = False

    def _add(self, node: ast.expr | ast.stmt, kind: str, new: ast.AST | str) -> None:
        text = new if isinstance(new, str) else f"({ast.unparse(ast.fix_missing_locations(new))})"
        assert node.end_lineno is not None
        assert node.end_col_offset is not None
        start = self._lines[node.lineno - 1] + node.col_offset
        end = self._lines[node.end_lineno - 1] + node.end_col_offset
        names = () if self._inside else self._names
        self.found.append(Mutant(self.path, kind, start, end, text, *self._span, names))

    def _with(self, node: ast.expr, kind: str, **fields: object) -> None:
        """Add a mutant: the node with some fields altered."""
        new = copy.copy(node)
        for name, value in fields.items():
            setattr(new, name, value)
        self._add(node, kind, new)

    def visit(self, node: ast.AST) -> None:
        """Walk on, with the lines of the statement."""
        if not isinstance(node, ast.stmt):
            super().visit(node)
            return
        before = self._span
        body = getattr(node, "body", None)
        last = max(node.lineno, body[0].lineno - 1) if body else node.end_lineno
        self._span = (node.lineno, last or node.lineno)
        super().visit(node)
        self._span = before

    def _block(self, statements: Sequence[ast.stmt]) -> None:
        for statement in statements:
            self.visit(statement)

    # Statements.

    def visit_FunctionDef(self, node: ast.FunctionDef | ast.AsyncFunctionDef) -> None:
        if node.name == "__repr__":
            return
        names, inside = self._names, self._inside
        self._span = (node.lineno, node.end_lineno or node.lineno)
        self._names = (node.name,)
        for default in (*node.args.defaults, *node.args.kw_defaults):
            if default is not None:
                self.visit(default)
        self._inside = True
        self._block(node.body)
        self._names, self._inside = names, inside

    visit_AsyncFunctionDef = visit_FunctionDef  # noqa: N815

    def visit_ClassDef(self, node: ast.ClassDef) -> None:
        names, self._names = self._names, (node.name,)
        self._block(node.body)
        self._names = names

    def visit_If(self, node: ast.If) -> None:
        if "TYPE_CHECKING" in ast.unparse(node.test):
            return
        self._condition(node.test)
        self._block(node.body)
        self._block(node.orelse)

    def visit_While(self, node: ast.While) -> None:
        self.visit_If(node)  # type: ignore[arg-type]

    def visit_Assign(self, node: ast.Assign) -> None:
        names = self._names
        if not self._inside:
            targets = [
                item for target in node.targets for item in ast.walk(target) if isinstance(item, ast.Name)
            ]
            self._names = (*names, *(item.id for item in targets))
            if self._names == ("__all__",):
                return
        if any(isinstance(target, ast.Attribute | ast.Subscript) for target in node.targets):
            self._add(node, "statement dropped", "pass")
        self.visit(node.value)
        self._names = names

    def visit_AnnAssign(self, node: ast.AnnAssign) -> None:
        names = self._names
        if not self._inside and isinstance(node.target, ast.Name):
            self._names = (*names, node.target.id)
        if node.value is not None:
            self.visit(node.value)
        self._names = names

    def visit_AugAssign(self, node: ast.AugAssign) -> None:
        self._add(node, "statement dropped", "pass")
        if type(node.op) in _OTHERS:
            new = copy.copy(node)
            new.op = _OTHERS[type(node.op)]()
            self._add(node, "operator", ast.unparse(new))
        self.visit(node.value)

    def visit_Expr(self, node: ast.Expr) -> None:
        inner = node.value.value if isinstance(node.value, ast.Await) else node.value
        if isinstance(inner, ast.Call):
            self._add(node, "statement dropped", "pass")
        self.visit(node.value)

    def visit_Raise(self, node: ast.Raise) -> None:
        self._add(node, "statement dropped", "pass")

    def visit_Break(self, node: ast.Break) -> None:
        self._add(node, "loop", "continue")

    def visit_Continue(self, node: ast.Continue) -> None:
        self._add(node, "loop", "break")
        self._add(node, "statement dropped", "pass")

    def visit_Return(self, node: ast.Return) -> None:
        value = node.value
        if value is None:
            self._add(node, "statement dropped", "pass")
            return
        if isinstance(value, ast.BoolOp):
            self._add(value, "negated", ast.UnaryOp(ast.Not(), value))
        self.visit(value)

    def visit_Assert(self, node: ast.Assert) -> None:
        pass

    # Expressions.

    def _condition(self, test: ast.expr) -> None:
        if isinstance(test, ast.UnaryOp) and isinstance(test.op, ast.Not):
            self.visit(test)
            return
        if not (isinstance(test, ast.Compare) and len(test.ops) == 1):
            self._add(test, "negated", ast.UnaryOp(ast.Not(), test))
        self.visit(test)

    def visit_IfExp(self, node: ast.IfExp) -> None:
        self._condition(node.test)
        self.visit(node.body)
        self.visit(node.orelse)

    def visit_comprehension(self, node: ast.comprehension) -> None:
        self.visit(node.iter)
        for test in node.ifs:
            self._add(test, "condition dropped", "True")
            self.visit(test)

    def visit_Compare(self, node: ast.Compare) -> None:
        for k, operator in enumerate(node.ops):
            for table, kind in ((_BORDERS, "border"), (_OPPOSITES, "comparison")):
                if type(operator) in table:
                    self._with(node, kind, ops=[*node.ops[:k], table[type(operator)](), *node.ops[k + 1 :]])
        self.visit(node.left)
        for operator, side in zip(node.ops, node.comparators, strict=True):
            self._member_of(side, operator)

    def _member_of(self, node: ast.expr, operator: ast.cmpop) -> None:
        """Walk through one side of a comparison; in which order members stand makes no difference."""
        if isinstance(operator, ast.In | ast.NotIn) and isinstance(node, ast.Tuple | ast.List):
            self.generic_visit(node)
        else:
            self.visit(node)

    def visit_BoolOp(self, node: ast.BoolOp) -> None:
        self._with(node, "and or", op=ast.Or() if isinstance(node.op, ast.And) else ast.And())
        for k in range(len(node.values)):
            rest = [*node.values[:k], *node.values[k + 1 :]]
            self._add(node, "operand dropped", rest[0] if len(rest) == 1 else ast.BoolOp(node.op, rest))
        self.generic_visit(node)

    def visit_BinOp(self, node: ast.BinOp) -> None:
        sides = (node.left, node.right)
        if any(isinstance(side, ast.JoinedStr) or _is_text(side) for side in sides):
            return
        if isinstance(node.op, ast.MatMult):
            self._with(node, "operands swapped", left=node.right, right=node.left)
        if type(node.op) in _OTHERS:
            self._with(node, "operator", op=_OTHERS[type(node.op)]())
            for side in sides:
                self._add(node, "operand dropped", side)
        self.generic_visit(node)

    def visit_UnaryOp(self, node: ast.UnaryOp) -> None:
        self._add(node, "sign", node.operand)
        self.visit(node.operand)

    def visit_Constant(self, node: ast.Constant) -> None:
        value = node.value
        if isinstance(value, bool):
            self._add(node, "constant", repr(not value))
        elif isinstance(value, int):
            self._add(node, "constant", repr(value + 1))
        elif isinstance(value, float):
            for other in (2 * value, value / 2) if value else (1.0,):
                self._add(node, "constant", repr(other))

    def visit_JoinedStr(self, node: ast.JoinedStr) -> None:
        pass  # Before Python 3.12 nodes in it do not know where they are.

    def visit_Call(self, node: ast.Call) -> None:
        name = getattr(node.func, "id", getattr(node.func, "attr", ""))
        if name == "TypeVar":
            return
        if name not in _COMMUTATIVE:
            for args in _exchanged(node.args):
                self._with(node, "arguments swapped", args=args)
        for k, keyword in enumerate(node.keywords):
            if keyword.arg is not None and keyword.arg not in _WORDS and not _asserts(keyword):
                rest = [*node.keywords[:k], *node.keywords[k + 1 :]]
                self._with(node, "argument dropped", keywords=rest)
        self.generic_visit(node)

    def visit_keyword(self, node: ast.keyword) -> None:
        if not _asserts(node):
            self.visit(node.value)

    def _display(self, node: ast.Tuple | ast.List) -> None:
        if isinstance(node.ctx, ast.Load) and len(node.elts) <= _LONG:
            for items in _exchanged(node.elts):
                self._with(node, "values swapped", elts=items)
        self.generic_visit(node)

    visit_Tuple = _display  # noqa: N815
    visit_List = _display  # noqa: N815

    def visit_Dict(self, node: ast.Dict) -> None:
        for values in _exchanged(node.values):
            self._with(node, "values swapped", values=values)
        self.generic_visit(node)


def _asserts(keyword: ast.keyword) -> bool:
    """Tell whether an argument is an assertion, or that there is none: nothing correct depends on it."""
    return keyword.arg == "strict" and isinstance(keyword.value, ast.Constant)


def _is_text(node: ast.expr) -> bool:
    return isinstance(node, ast.Constant) and isinstance(node.value, str | bytes)
