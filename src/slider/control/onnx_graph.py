"""Converts a function of tensors to an ONNX graph, so that what was trained is what is exported.

torch records the operators that the function calls on an example; each becomes one or a few ONNX
operators. Values that depend on no input are folded into constants.
"""

import operator
from collections.abc import Callable, Mapping, Sequence
from pathlib import Path
from typing import Any

import numpy as np
import onnx
import torch
from onnx import TensorProto, helper, numpy_helper
from torch.func import functionalize
from torch.fx.experimental.proxy_tensor import make_fx

IR, OPSET = 8, 13  # of ONNX 1.10
_ROBOTS = 997  # batch size of the example: unlike any other size, it marks the batch dimension
_TABLE = 10_000  # float64 constants with more numbers are stored in single precision
_TYPES = {
    torch.float64: TensorProto.DOUBLE,
    torch.float32: TensorProto.FLOAT,
    torch.int64: TensorProto.INT64,
    torch.bool: TensorProto.BOOL,
}

Function = Callable[..., Sequence[torch.Tensor]]


def save(
    function: Function,
    inputs: Mapping[str, int],
    outputs: Sequence[str],
    metadata: Mapping[str, str],
    path: Path,
) -> None:
    """Write a function as an ONNX file.

    Args:
        function: tensors (N, width) → tensors (N, width), float64, robot by robot.
        inputs: widths by name, in the order of the function's arguments.
        outputs: names.
        metadata: of the file.
        path: of the file.

    Raises:
        NotImplementedError: the function uses an operator that has no counterpart here.
    """
    generator = torch.Generator().manual_seed(0)
    example = [
        torch.rand(_ROBOTS, width, dtype=torch.float64, generator=generator)
        for width in inputs.values()
    ]
    with torch.no_grad():
        pure = functionalize(lambda *given: tuple(function(*given)), remove="mutations_and_views")
        recorded = make_fx(pure)(*example)
        graph = _Graph(recorded, dict(zip(inputs, example, strict=True)))
    results = graph.results(outputs)
    given, made = (
        [helper.make_tensor_value_info(n, TensorProto.DOUBLE, ["robots", w]) for n, w in sizes]
        for sizes in (inputs.items(), [(name, value.shape[1]) for name, value in results])
    )
    constants = [numpy_helper.from_array(array, name) for name, array in graph.used_constants()]
    whole = helper.make_graph(graph.used_nodes(), path.stem, given, made, constants)
    opset = [helper.make_opsetid("", OPSET)]
    model = helper.make_model(whole, ir_version=IR, opset_imports=opset, producer_name="slider")
    helper.set_model_props(model, dict(metadata))
    onnx.checker.check_model(model, full_check=True)
    path.write_bytes(model.SerializeToString(deterministic=True))


class _Value:
    """A tensor of the example; its name in the graph, ``None`` for a constant."""

    def __init__(self, tensor: torch.Tensor, name: str | None = None) -> None:
        self.tensor, self.name = tensor, name


class _Graph:
    """Nodes and constants of an ONNX graph, from a recorded function."""

    def __init__(self, recorded: torch.fx.GraphModule, inputs: Mapping[str, torch.Tensor]) -> None:
        self._nodes: list[onnx.NodeProto] = []
        self._known: dict[Any, str] = {}  # equal nodes and constants are added once
        self._written: dict[str, Any] = {}  # arguments of the operator that wrote a row
        self._constants: dict[str, np.ndarray] = {}
        self._values: dict[torch.fx.Node, Any] = {}
        self._first = next(iter(inputs))
        given = iter(inputs.items())
        for node in recorded.graph.nodes:
            if node.op == "placeholder":
                name, tensor = next(given)
                self._values[node] = _Value(tensor, name)
            elif node.op == "get_attr":
                self._values[node] = _Value(getattr(recorded, str(node.target)))
            elif node.op == "output":
                returned: Any = node.args[0]
                self._returned = [self._values[value] for value in returned]
            else:
                self._values[node] = self._call(node)

    def results(self, names: Sequence[str]) -> list[tuple[str, torch.Tensor]]:
        """Name the returned values; return the names with the values of the example."""
        for name, value in zip(names, self._returned, strict=True):
            self._nodes.append(helper.make_node("Identity", [self.ref(value, whole=True)], [name]))
        self._outputs = set(names)
        return [(n, value.tensor) for n, value in zip(names, self._returned, strict=True)]

    def used_nodes(self) -> list[onnx.NodeProto]:
        """Nodes that the outputs depend on."""
        needed, used = set(self._outputs), []
        for node in reversed(self._nodes):
            if needed & set(node.output):
                needed |= set(node.input)
                used.append(node)
        self._needed = needed
        return used[::-1]

    def used_constants(self) -> list[tuple[str, np.ndarray]]:
        """Constants that the nodes use."""
        self.used_nodes()
        return [item for item in self._constants.items() if item[0] in self._needed]

    def _call(self, node: torch.fx.Node) -> Any:
        """Value of a torch operator, or list of values."""
        target: Any = node.target
        args: Any = torch.fx.map_arg(node.args, self._values.__getitem__)
        kwargs: Any = torch.fx.map_arg(node.kwargs, self._values.__getitem__)
        if target is operator.getitem:  # an element of an unbound tensor
            return args[0][args[1]]
        plain, options = (_map(given, lambda value: value.tensor) for given in (args, kwargs))
        result = target(*plain, **options)
        name = target.overloadpacket.__name__.removesuffix("_copy")
        read = () if name.endswith("_like") else args[1:] if name in ("fill", "copy") else args
        dynamic: list[str] = []
        _map((read, kwargs), lambda value: dynamic.append(value.name) if value.name else None)
        if not dynamic:
            return _map(result, _Value)
        if name == "unbind":
            dim = args[1] if len(args) > 1 else 0
            return [self._select(args[0], dim, k, each) for k, each in enumerate(result)]
        if name == "select":
            return self._select(args[0], args[1], args[2], result)
        if name not in _OPERATORS:
            raise NotImplementedError(f"no ONNX operator for {name} of torch")
        made = _OPERATORS[name](self, result, *args, **kwargs)
        if name == "select_scatter":
            self._written[made] = args
        return _Value(result, made)

    def _select(self, value: _Value, dim: int, index: int, result: torch.Tensor) -> _Value:
        """A row; one that was written before is returned without a look-up."""
        while value.name in self._written and self._written[value.name][2] == dim:
            before, row, _, at = self._written[value.name]
            if at == index:
                return row
            value = before
        if value.name is None:
            return _Value(value.tensor.select(dim, index))
        gathered = self.add("Gather", self.ref(value), self.constant(index), axis=dim)
        return _Value(result, gathered)

    def add(self, operation: str, *inputs: str, **attributes: Any) -> str:
        """Add a node, unless it exists; return the name of its result."""
        key = operation, inputs, tuple(attributes.items())
        if key not in self._known:
            self._known[key] = f"{operation.lower()}{len(self._nodes)}"
            made = helper.make_node(operation, list(inputs), [self._known[key]], **attributes)
            self._nodes.append(made)
        return self._known[key]

    def constant(self, value: Any, dtype: torch.dtype = torch.int64) -> str:
        """Name of a constant."""
        tensor = torch.as_tensor(value, dtype=dtype).contiguous()
        if dtype == torch.float64 and tensor.numel() > _TABLE:
            single = self.constant(tensor, torch.float32)
            return self.add("Cast", single, to=TensorProto.DOUBLE)
        array = tensor.numpy()
        key = "constant", array.dtype.str, array.shape, array.tobytes()
        if key not in self._known:
            self._known[key] = f"constant{len(self._constants)}"
            self._constants[self._known[key]] = array
        return self._known[key]

    def ref(self, value: Any, dtype: torch.dtype | None = None, whole: bool = False) -> str:
        """Name of a value, cast to a type.

        A constant is stored for one robot and broadcast; ``whole`` expands it to all robots.
        """
        if not isinstance(value, _Value):
            return self.constant(value, dtype or torch.float64)
        dtype, shape = dtype or value.tensor.dtype, value.tensor.shape
        if value.name is not None:
            same = value.tensor.dtype == dtype
            return value.name if same else self.add("Cast", value.name, to=_TYPES[dtype])
        one = value.tensor.to(dtype)
        for dim, size in enumerate(shape):
            one = one.narrow(dim, 0, 1) if size == _ROBOTS else one
        name = self.constant(one, dtype)
        return self.expand(name, shape) if whole and _ROBOTS in shape else name

    def expand(self, name: str, shape: Sequence[int]) -> str:
        """Broadcast to a shape."""
        number = self.add("Shape", self._first)
        count = self.add("Slice", number, self.constant([0]), self.constant([1]))
        sizes = [count if n == _ROBOTS else self.constant([n]) for n in shape]
        return self.add("Expand", name, self.add("Concat", *sizes, axis=0))


def _map(values: Any, function: Callable[[Any], Any]) -> Any:
    """Apply a function to the values and tensors in nested lists and dictionaries."""
    if isinstance(values, _Value | torch.Tensor):
        return function(values)
    if isinstance(values, dict):
        return {name: _map(value, function) for name, value in values.items()}
    if isinstance(values, tuple | list):
        return [_map(value, function) for value in values]
    return values


def _same_type(operation: str) -> Callable[..., str]:
    """An operator whose arguments have the type of its result."""
    return lambda g, out, *args: g.add(operation, *(g.ref(a, out.dtype) for a in args))


def _compare(operation: str) -> Callable[..., str]:
    return lambda g, _, a, b: g.add(operation, g.ref(a), g.ref(b, a.tensor.dtype))


def _reduce(operation: str) -> Callable[..., str]:
    return lambda g, _, x, dims, keep=False: g.add(
        operation, g.ref(x), axes=tuple(dims), keepdims=int(keep)
    )


def _copy(g: _Graph, out: torch.Tensor, _: Any, value: _Value) -> str:
    name = g.ref(value, out.dtype)
    return name if value.tensor.shape == out.shape and value.name else g.expand(name, out.shape)


def _clamp(g: _Graph, out: torch.Tensor, x: _Value, low: Any = None, high: Any = None) -> str:
    name = g.ref(x, out.dtype)
    name = name if low is None else g.add("Max", name, g.ref(low, out.dtype))
    return name if high is None else g.add("Min", name, g.ref(high, out.dtype))


def _slice(
    g: _Graph,
    out: torch.Tensor,
    x: _Value,
    dim: int = 0,
    start: Any = 0,
    end: Any = None,
    *step: Any,
) -> str:
    if out.shape == x.tensor.shape:
        return g.ref(x)
    first, last, _ = slice(start, end, *step).indices(x.tensor.shape[dim])
    return _cut(g, g.ref(x), dim, first, last)


def _cut(g: _Graph, name: str, dim: int, first: int, last: int) -> str:
    return g.add("Slice", name, *(g.constant([k]) for k in (first, last, dim)))


def _select_scatter(
    g: _Graph, out: torch.Tensor, x: _Value, row: _Value, dim: int, index: int
) -> str:
    """``x`` with ``row`` at ``index`` of dimension ``dim``."""
    here = (torch.arange(out.shape[dim]) == index).reshape([-1] + [1] * (out.dim() - dim - 1))
    row_there = g.add("Unsqueeze", g.ref(row, out.dtype, whole=True), g.constant([dim]))
    return g.add("Where", g.ref(_Value(here)), row_there, g.ref(x))


def _slice_scatter(
    g: _Graph, out: torch.Tensor, x: _Value, part: _Value, dim: int = 0, *ends: Any
) -> str:
    size, whole = out.shape[dim], g.ref(x, whole=True)
    first, last, _ = slice(*ends).indices(size)
    before, after = (
        [_cut(g, whole, dim, *s)] if s[0] < s[1] else [] for s in ((0, first), (last, size))
    )
    return g.add("Concat", *before, g.ref(part, out.dtype, whole=True), *after, axis=dim)


def _cat(g: _Graph, out: torch.Tensor, values: Sequence[_Value], dim: int = 0) -> str:
    parts = [g.ref(value, out.dtype, whole=True) for value in values]
    return g.add("Concat", *parts, axis=dim % out.dim())


def _stack(g: _Graph, out: torch.Tensor, values: Sequence[_Value], dim: int = 0) -> str:
    place = g.constant([dim % out.dim()])
    parts = [g.add("Unsqueeze", g.ref(v, out.dtype, whole=True), place) for v in values]
    return g.add("Concat", *parts, axis=dim % out.dim())


def _index(g: _Graph, _: Any, x: _Value, places: Sequence[_Value | None]) -> str:
    """Rows along one axis, or entries of a table by indices of its first axes."""
    given = [place for place in places if place is not None]
    if len(given) > 1:
        last, whole = g.constant([-1]), {"dtype": torch.int64, "whole": True}
        columns = [g.add("Unsqueeze", g.ref(place, **whole), last) for place in given]
        return g.add("GatherND", g.ref(x), g.add("Concat", *columns, axis=-1))
    axis, place = places.index(given[0]), given[0]
    if place.tensor.dtype == torch.bool and place.name is None:
        place = _Value(place.tensor.nonzero()[:, 0])
    return g.add("Gather", g.ref(x), g.ref(place), axis=axis)


def _searchsorted(g: _Graph, _: Any, edges: _Value, x: _Value, *, side: str = "left") -> str:
    """Number of sorted edges (K,) below each value, with ``side`` right: not above it."""
    last = g.constant([-1])
    below = "LessOrEqual" if side == "right" else "Less"
    under = g.add(below, g.ref(edges), g.add("Unsqueeze", g.ref(x), last))
    return g.add("ReduceSum", g.add("Cast", under, to=TensorProto.INT64), last, keepdims=0)


def _shaped(g: _Graph, out: torch.Tensor, x: _Value, *_: Any) -> str:
    sizes = [size if size % _ROBOTS else -1 for size in out.shape]
    return g.add("Reshape", g.ref(x, whole=True), g.constant(sizes))


def _sum(g: _Graph, _: Any, x: _Value, dims: Sequence[int], keep: bool = False) -> str:
    return g.add("ReduceSum", g.ref(x), g.constant(dims), keepdims=int(keep))


def _all(g: _Graph, _: Any, x: _Value, dim: int) -> str:
    number = g.add("Cast", g.ref(x), to=TensorProto.INT64)
    least = g.add("ReduceMin", number, axes=(dim,), keepdims=0)
    return g.add("Cast", least, to=TensorProto.BOOL)


def _square(g: _Graph, x: _Value) -> str:
    return g.add("Mul", g.ref(x), g.ref(x))


def _power(g: _Graph, out: torch.Tensor, x: _Value, exponent: float) -> str:
    return _square(g, x) if exponent == 2 else g.add("Pow", g.ref(x), g.ref(exponent, out.dtype))


def _norm(
    g: _Graph, _: Any, x: _Value, order: float, dims: Sequence[int], keep: bool = False
) -> str:
    assert order == 2
    return g.add("Sqrt", g.add("ReduceSum", _square(g, x), g.constant(dims), keepdims=int(keep)))


def _hypot(g: _Graph, _: Any, x: _Value, y: _Value) -> str:
    return g.add("Sqrt", g.add("Add", _square(g, x), _square(g, y)))


def _cross(g: _Graph, _: Any, a: _Value, b: _Value, *, dim: int = -1) -> str:
    (a_next, a_last), (b_next, b_last) = (
        [g.add("Gather", g.ref(x), g.constant(order), axis=dim) for order in ([1, 2, 0], [2, 0, 1])]
        for x in (a, b)
    )
    return g.add("Sub", g.add("Mul", a_next, b_last), g.add("Mul", a_last, b_next))


def _cosine(g: _Graph, angle: str) -> str:
    """Cosine by the sine: onnxruntime 1.15 has no cosine in double precision."""
    return g.add("Sin", g.add("Add", angle, g.ref(0.5 * np.pi)))


def _atan2(g: _Graph, _: Any, y: _Value, x: _Value) -> str:
    """The angle of a vector.

    Runtimes have the arc tangent in single precision only, so one Newton step follows.
    """
    sine, cosine = (g.add("Div", g.ref(v), _hypot(g, _, x, y)) for v in (y, x))
    zero, pi = g.ref(0.0), g.ref(np.pi)
    ratio = g.add("Cast", g.add("Div", sine, cosine), to=TensorProto.FLOAT)
    angle = g.add("Cast", g.add("Atan", ratio), to=TensorProto.DOUBLE)
    half = g.add("Where", g.add("Less", sine, zero), g.add("Neg", pi), pi)
    behind = g.add("Less", cosine, zero)
    angle = g.add("Add", angle, g.add("Where", behind, half, zero))
    left = g.add("Mul", sine, _cosine(g, angle)), g.add("Mul", cosine, g.add("Sin", angle))
    return g.add("Add", angle, g.add("Sub", *left))


def _remainder(g: _Graph, _: Any, x: _Value, divisor: float) -> str:
    """Remainder with the sign of the divisor, which is positive."""
    rest = g.add("Mod", g.ref(x), g.ref(divisor), fmod=1)
    below = g.add("Less", rest, g.ref(0.0))
    return g.add("Where", below, g.add("Add", rest, g.ref(divisor)), rest)


_SAME_TYPE = (
    *(
        "add:Add",
        "sub:Sub",
        "mul:Mul",
        "div:Div",
        "neg:Neg",
        "bmm:MatMul",
        "mm:MatMul",
        "mv:MatMul",
    ),
    *("sin:Sin", "exp:Exp", "tanh:Tanh", "abs:Abs", "ceil:Ceil", "relu:Relu", "sqrt:Sqrt"),
    *("bitwise_not:Not", "bitwise_and:And", "bitwise_or:Or"),
)
_COMPARISONS = ("ge:GreaterOrEqual", "gt:Greater", "le:LessOrEqual", "lt:Less", "eq:Equal")
_OPERATORS: dict[str, Callable[..., str]] = {
    **{name: _same_type(other) for name, other in (pair.split(":") for pair in _SAME_TYPE)},
    **{name: _compare(other) for name, other in (pair.split(":") for pair in _COMPARISONS)},
    **dict.fromkeys(
        ("clone", "alias", "detach", "lift_fresh", "_to"),
        lambda g, out, x, **_: g.ref(x, out.dtype),
    ),
    **dict.fromkeys(("view", "_unsafe_view"), _shaped),
    **dict.fromkeys(("copy", "fill"), _copy),
    "expand": lambda g, out, x, *_: g.expand(g.ref(x), out.shape),
    "permute": lambda g, _, x, order: g.add("Transpose", g.ref(x), perm=tuple(order)),
    "t": lambda g, _, x: g.add("Transpose", g.ref(x), perm=(1, 0)),
    "unsqueeze": lambda g, _, x, dim: g.add("Unsqueeze", g.ref(x), g.constant([dim])),
    "where": lambda g, out, condition, a, b: g.add(
        "Where", g.ref(condition), g.ref(a, out.dtype), g.ref(b, out.dtype)
    ),
    "elu": lambda g, _, x, alpha=1.0: g.add("Elu", g.ref(x), alpha=float(alpha)),
    "rsub": lambda g, out, a, b: g.add("Sub", g.ref(b, out.dtype), g.ref(a, out.dtype)),
    "reciprocal": lambda g, out, x: g.add("Div", g.ref(1.0, out.dtype), g.ref(x)),
    "addmm": lambda g, _, bias, x, weight: g.add("Gemm", g.ref(x), g.ref(weight), g.ref(bias)),
    "cos": lambda g, _, x: _cosine(g, g.ref(x)),
    "clamp": _clamp,
    "slice": _slice,
    "select_scatter": _select_scatter,
    "slice_scatter": _slice_scatter,
    "cat": _cat,
    "stack": _stack,
    "index": _index,
    "searchsorted": _searchsorted,
    "sum": _sum,
    "mean": _reduce("ReduceMean"),
    "amax": _reduce("ReduceMax"),
    "all": _all,
    "pow": _power,
    "linalg_vector_norm": _norm,
    "linalg_cross": _cross,
    "hypot": _hypot,
    "atan2": _atan2,
    "remainder": _remainder,
}
"""Converters of torch operators, by name."""
