"""Tags to print: as SVG files, and on PDF pages to be cut."""
from __future__ import annotations

import io
from typing import Sequence

from reportlab.lib.pagesizes import A4, LETTER
from reportlab.lib.units import mm
from reportlab.pdfgen.canvas import Canvas

from aruco_ar.base.arrays import Image
from aruco_ar.base.errors import InputError
from aruco_ar.base.progress import progress

from .tag import check_quiet, check_size, tag_cells

PAGES = {'A4': A4, 'Letter': LETTER}

MARGIN_MM = 10       # most printers leave this much of the paper blank
RULER_MM = 100
FOOT_MM = 18         # the strip at the page's foot that holds the ruler
CAPTION_MM = 4       # the line under each tag that holds its id


def black_runs(cells: Image) -> list[tuple[int, int, int]]:
    """The black cells of a tag as rectangles that are one cell high: (row, column, length) of each."""
    runs = []
    for row, line in enumerate(cells):
        column = 0
        while column < len(line):
            length = 0
            while column + length < len(line) and line[column + length] == 0:
                length += 1
            if length:
                runs.append((row, column, length))
            column += length + 1
    return runs


def tag_svg(dictionary: str, tag_id: int, size: int = 700, border: int = 1, quiet: float = 0) -> str:
    """One tag as SVG text; the arguments and errors are those of ``draw_tag``.

    All cells are one path, so that no viewer shows hairlines between them.
    """
    cells = tag_cells(dictionary, tag_id, border)
    check_size(len(cells), size)
    check_quiet(quiet)
    total = len(cells) + 2 * quiet
    side = size * total / len(cells)
    path = ' '.join('M%g %gh%dv1h-%dz' % (column + quiet, row + quiet, length, length)
                    for row, column, length in black_runs(cells))
    return ('<svg xmlns="http://www.w3.org/2000/svg" width="%g" height="%g" viewBox="0 0 %g %g">\n'
            '<title>%s id %d</title>\n'
            '<rect width="%g" height="%g" fill="white"/>\n'
            '<path d="%s" fill="black"/>\n'
            '</svg>\n' % (side, side, total, total, dictionary, tag_id, total, total, path))


def tag_sheet(dictionary: str, ids: Sequence[int], side_mm: float, page: str = 'A4', border: int = 1,
              quiet: float = 1) -> bytes:
    """Pages to print, as the bytes of a PDF file.

    ``side_mm``: the side of each tag, exact if printed at 100 %. ``quiet``: the
    width of the white margin in cells; a line to cut along surrounds it. The id
    is in small print below each tag. Each page has a ruler to check the print.
    Raises InputError for an unknown id or page size, and for tags that do not
    fit on the page.
    """
    if page not in PAGES:
        raise InputError('There is no page size "%s"; choose one of %s.' % (page, ', '.join(PAGES)))
    if not 1 <= side_mm <= 1000:
        raise InputError('A tag with a side of %g mm cannot be printed; choose from 1 to 1000.' % side_mm)
    check_quiet(quiet)
    tags = [(tag_id, tag_cells(dictionary, tag_id, border)) for tag_id in ids]
    cell_mm = side_mm / len(tags[0][1])
    cut_mm = side_mm + 2 * quiet * cell_mm
    width_mm, height_mm = (length / mm for length in PAGES[page])
    columns = int((width_mm - 2 * MARGIN_MM) // cut_mm)
    rows = int((height_mm - 2 * MARGIN_MM - FOOT_MM) // (cut_mm + CAPTION_MM))
    if columns < 1 or rows < 1:
        largest = min(width_mm - 2 * MARGIN_MM, height_mm - 2 * MARGIN_MM - FOOT_MM - CAPTION_MM)
        raise InputError('Tags with a side of %g mm do not fit on %s; the largest possible side is %d mm.'
                         % (side_mm, page, int(largest * side_mm / cut_mm)))

    file = io.BytesIO()
    canvas = Canvas(file, pagesize=PAGES[page], pageCompression=1)
    canvas.setTitle('%s, side %g mm' % (dictionary, side_mm))
    for start in progress(range(0, len(tags), columns * rows), 'pages'):
        for place, (tag_id, cells) in enumerate(tags[start:start + columns * rows]):
            row, column = divmod(place, columns)
            left = MARGIN_MM + column * cut_mm
            foot = height_mm - MARGIN_MM - cut_mm - row * (cut_mm + CAPTION_MM)
            _draw_cut_line(canvas, left, foot, cut_mm)
            _draw_cells(canvas, cells, left + quiet * cell_mm, foot + quiet * cell_mm, cell_mm)
            canvas.setFont('Helvetica', 7)
            canvas.drawString((left + 1) * mm, (foot - CAPTION_MM + 1.5) * mm,
                              '%s  id %d  side %g mm' % (dictionary, tag_id, side_mm))
        _draw_ruler(canvas)
        canvas.showPage()
    canvas.save()
    return file.getvalue()


def _draw_cells(canvas: Canvas, cells: Image, left: float, foot: float, cell_mm: float) -> None:
    """Fill the black cells, as one path. In a PDF, y points up."""
    path = canvas.beginPath()
    for row, column, length in black_runs(cells):
        path.rect((left + column * cell_mm) * mm, (foot + (len(cells) - 1 - row) * cell_mm) * mm,
                  length * cell_mm * mm, cell_mm * mm)
    canvas.drawPath(path, fill=1, stroke=0)


def _draw_cut_line(canvas: Canvas, left: float, foot: float, side: float) -> None:
    canvas.saveState()
    canvas.setLineWidth(0.3)
    canvas.setStrokeGray(0.5)
    canvas.setDash(3, 3)
    canvas.rect(left * mm, foot * mm, side * mm, side * mm)
    canvas.restoreState()


def _draw_ruler(canvas: Canvas) -> None:
    """A ruler of RULER_MM at the foot of the page."""
    foot = MARGIN_MM + 4
    canvas.setLineWidth(0.3)
    canvas.line(MARGIN_MM * mm, foot * mm, (MARGIN_MM + RULER_MM) * mm, foot * mm)
    for tick in range(RULER_MM + 1):
        height = 4 if tick % 10 == 0 else 3 if tick % 5 == 0 else 2
        x = (MARGIN_MM + tick) * mm
        canvas.line(x, foot * mm, x, (foot + height) * mm)
    canvas.setFont('Helvetica', 7)
    for tick in range(0, RULER_MM + 1, 10):
        canvas.drawCentredString((MARGIN_MM + tick) * mm, (foot + 5) * mm, str(tick))
    canvas.drawString(MARGIN_MM * mm, (MARGIN_MM + 0.5) * mm,
                      'Millimeters. Check with a ruler; if it is off, print again at 100 %, '
                      'without "fit to page".')
