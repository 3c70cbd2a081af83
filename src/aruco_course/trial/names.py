"""Reads the learner's source."""
from __future__ import annotations

import ast
import builtins
from typing import Iterator, Union

Function = Union[ast.FunctionDef, ast.AsyncFunctionDef]


def read_tree(path: str) -> ast.Module:
    """The file's syntax tree; an empty one if it cannot be read."""
    try:
        with open(path, 'rb') as file:
            return ast.parse(file.read())
    except (OSError, SyntaxError, ValueError, RecursionError, MemoryError):
        return ast.Module(body=[], type_ignores=[])


def top_statements(tree: ast.Module) -> Iterator[ast.stmt]:
    """The statements that run when the file is imported, also those in if, try, with and for."""
    waiting = list(reversed(tree.body))
    while waiting:
        statement = waiting.pop()
        yield statement
        if isinstance(statement, (ast.FunctionDef, ast.AsyncFunctionDef, ast.ClassDef)):
            continue
        inner = [child for child in ast.iter_child_nodes(statement) if isinstance(child, ast.stmt)]
        inner += [child for handler in getattr(statement, 'handlers', []) for child in handler.body]
        waiting += reversed(inner)


def top_functions(tree: ast.Module) -> dict[str, Function]:
    """The functions that the file defines, by their names; of several of one name, the last."""
    return {one.name: one for one in top_statements(tree)
            if isinstance(one, (ast.FunctionDef, ast.AsyncFunctionDef))}


def other_names(tree: ast.Module) -> set[str]:
    """The names that the file gets by assigning or importing them."""
    names = set()
    for statement in top_statements(tree):
        if isinstance(statement, (ast.Import, ast.ImportFrom)):
            names |= {(alias.asname or alias.name).split('.')[0] for alias in statement.names}
        elif isinstance(statement, (ast.Assign, ast.AnnAssign)):
            names |= {node.id for node in ast.walk(statement)
                      if isinstance(node, ast.Name) and isinstance(node.ctx, ast.Store)}
    return names


def bound(tree: ast.Module) -> set[str]:
    """All names that have a value anywhere in the file, and Python's own."""
    names = {'__file__', '__class__', *vars(builtins)}
    for node in ast.walk(tree):
        if isinstance(node, ast.Name) and not isinstance(node.ctx, ast.Load):
            names.add(node.id)
        elif isinstance(node, ast.arg):
            names.add(node.arg)
        elif isinstance(node, ast.alias):
            names.add((node.asname or node.name).split('.')[0])
        elif isinstance(getattr(node, 'name', None), str):  # functions, classes, and what "as" gives
            names.add(vars(node)['name'])
    return names


def called(call: ast.Call) -> str:
    """The name of what is called, behind the last dot."""
    func = call.func
    return func.attr if isinstance(func, ast.Attribute) else func.id if isinstance(func, ast.Name) else ''


def text_of(node: ast.expr) -> str | None:
    """The text that is written there, or None if it is none, or is computed."""
    return node.value if isinstance(node, ast.Constant) and isinstance(node.value, str) else None


def imported(tree: ast.Module) -> list[str]:
    """The modules that the file imports; '.' for one beside it."""
    names = []
    for node in ast.walk(tree):
        if isinstance(node, ast.Import):
            names += [alias.name for alias in node.names]
        elif isinstance(node, ast.ImportFrom):
            names.append('.' if node.level else node.module or '')
    return names
