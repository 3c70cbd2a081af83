"""Reads the learner's source."""
from __future__ import annotations

import ast
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
