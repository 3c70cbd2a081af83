"""Tags to print: as SVG files, and on PDF pages to be cut."""
from __future__ import annotations

import io
from typing import Sequence

from reportlab.lib.pagesizes import A3, A4, LETTER, landscape
from reportlab.lib.units import mm
from reportlab.pdfgen.canvas import Canvas

from aruco_ar.base.arrays import Image
from aruco_ar.base.errors import InputError
from aruco_ar.base.progress import progress

from .instructions import draw_arrow, draw_instructions
from .tag import check_quiet, tag_cells

PAGES = {'A4': A4, 'A3': A3, 'Letter': LETTER}

MARGIN_MM = 10       # most printers leave this much of the paper blank
RULER_MM = 100
FOOT_MM = 18         # the strip at the page's foot that holds the ruler
CAPTION_MM = 4       # the line under each tag that holds its id
LABEL_MM = 2.5       # the height of the id and the arrow in the margin of a tag
LABEL_SHARE = 0.4    # that height is at most this share of the margin: a label near the tag would hide its edge
MIN_LABEL_MM = 1.0


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


def tag_svg(dictionary: str, tag_id: int, side_mm: float = 75, border: int = 1, quiet: float = 0) -> str:
    """One tag as SVG text, which programs show and print with a side of ``side_mm`` millimeters.

    The other arguments and the errors are those of ``draw_tag``. All cells are one path, so that no viewer
    shows hairlines between them.
    """
    cells = tag_cells(dictionary, tag_id, border)
    _check_side(side_mm)
    check_quiet(quiet)
    total = len(cells) + 2 * quiet
    side = side_mm * total / len(cells)
    path = ' '.join('M%g %gh%dv1h-%dz' % (column + quiet, row + quiet, length, length)
                    for row, column, length in black_runs(cells))
    return ('<svg xmlns="http://www.w3.org/2000/svg" width="%gmm" height="%gmm" viewBox="0 0 %g %g">\n'
            '<title>%s id %d</title>\n'
            '<rect width="%g" height="%g" fill="white"/>\n'
            '<path d="%s" fill="black"/>\n'
            '</svg>\n' % (side, side, total, total, dictionary, tag_id, total, total, path))


def tag_sheet(dictionary: str, ids: Sequence[int], side_mm: float, page: str = 'A4', border: int = 1,
              quiet: float = 1) -> bytes:
    """Pages to print, as the bytes of a PDF file. The last page says how to hang the tags.

    ``side_mm``: the side of each tag, exact if printed at 100 %. ``quiet``: the
    width of the white margin in cells; a line to cut along surrounds it. In the
    margin are the id and an arrow that points up. Each page has a ruler to check
    the print. Four tags on a page are placed as they belong on the wall.
    Raises InputError for an unknown id or page size, and for tags that do not
    fit on the page.
    """
    _check(side_mm, page, quiet)
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

    if len(tags) == 4 and columns == 2:
        tags = [tags[0], tags[1], tags[3], tags[2]]  # clockwise, as around a picture
    file = io.BytesIO()
    canvas = Canvas(file, pagesize=PAGES[page], pageCompression=1)
    canvas.setTitle('%s, side %g mm' % (dictionary, side_mm))
    for start in progress(range(0, len(tags), columns * rows), 'pages'):
        for place, (tag_id, cells) in enumerate(tags[start:start + columns * rows]):
            row, column = divmod(place, columns)
            left = MARGIN_MM + column * cut_mm
            foot = height_mm - MARGIN_MM - cut_mm - row * (cut_mm + CAPTION_MM)
            _draw_cut_line(canvas, left, foot, cut_mm)
            _draw_tag(canvas, tag_id, cells, left, foot, cell_mm, quiet)
            canvas.setFont('Helvetica', 7)
            canvas.drawString((left + 1) * mm, (foot - CAPTION_MM + 1.5) * mm,
                              '%s  id %d  side %g mm' % (dictionary, tag_id, side_mm))
        _draw_ruler(canvas, MARGIN_MM, side_mm)
        canvas.showPage()
    draw_instructions(canvas, width_mm, height_mm, ids, side_mm)
    canvas.save()
    return file.getvalue()


def tags_around_picture(dictionary: str, ids: Sequence[int], side_mm: float, page: str = 'A4', border: int = 1,
                        quiet: float = 1) -> bytes:
    """One page to put up as it is, with a tag in each corner, as the bytes of a PDF file.

    ``ids``: those of the four tags, clockwise from the top left. The other arguments and the errors are as in
    ``tag_sheet``.
    """
    _check(side_mm, page, quiet)
    if len(set(ids)) != 4:
        raise InputError('Around a picture are four different tags, not %d. Give four ids.' % len(set(ids)))
    tags = [(tag_id, tag_cells(dictionary, tag_id, border)) for tag_id in ids]
    cell_mm = side_mm / len(tags[0][1])
    cut_mm = side_mm + 2 * quiet * cell_mm
    width_mm, height_mm = (length / mm for length in landscape(PAGES[page]))
    right, top = width_mm - MARGIN_MM - cut_mm, height_mm - MARGIN_MM - cut_mm
    if right - MARGIN_MM - cut_mm < RULER_MM or top - MARGIN_MM < cut_mm:
        largest = min(width_mm - 2 * MARGIN_MM - RULER_MM, height_mm - 2 * MARGIN_MM) / 2
        raise InputError('Four tags with a side of %g mm do not fit around a picture on %s; the largest '
                         'possible side is %d mm.' % (side_mm, page, int(largest * side_mm / cut_mm)))
    file = io.BytesIO()
    canvas = Canvas(file, pagesize=landscape(PAGES[page]), pageCompression=1)
    canvas.setTitle('%s, side %g mm, around a picture' % (dictionary, side_mm))
    places = (MARGIN_MM, top), (right, top), (right, MARGIN_MM), (MARGIN_MM, MARGIN_MM)
    for (tag_id, cells), (left, foot) in zip(tags, places):
        _draw_tag(canvas, tag_id, cells, left, foot, cell_mm, quiet)
    canvas.setFont('Helvetica', 9)
    canvas.setFillGray(0.5)
    size_mm = right - MARGIN_MM, top - MARGIN_MM
    lines = ('%s   %s' % (dictionary, ' '.join(map(str, ids))),
             'The picture goes here, from center to center: %.0f x %.0f mm' % size_mm,
             'Put this page up as it is, flat, this side up.')
    for number, line in enumerate(lines):
        canvas.drawCentredString(width_mm / 2 * mm, (height_mm / 2 + 5 - 5 * number) * mm, line)
    canvas.setFillGray(0)
    _draw_ruler(canvas, (width_mm - RULER_MM) / 2, side_mm)
    canvas.save()
    return file.getvalue()


def _check(side_mm: float, page: str, quiet: float) -> None:
    if page not in PAGES:
        raise InputError('There is no page size "%s"; choose one of %s.' % (page, ', '.join(PAGES)))
    _check_side(side_mm)
    check_quiet(quiet)


def _check_side(side_mm: float) -> None:
    if not 1 <= side_mm <= 1000:
        raise InputError('A tag with a side of %g mm cannot be printed; choose from 1 to 1000.' % side_mm)


def _draw_tag(canvas: Canvas, tag_id: int, cells: Image, left: float, foot: float, cell_mm: float,
              quiet: float) -> None:
    """Draw a tag with its margin, and in that, in gray, an arrow that points up and its id."""
    margin, cut_mm = quiet * cell_mm, (len(cells) + 2 * quiet) * cell_mm
    _draw_cells(canvas, cells, left + margin, foot + margin, cell_mm)
    height = min(LABEL_MM, LABEL_SHARE * margin)
    if height < MIN_LABEL_MM:
        return
    canvas.saveState()
    canvas.setFillGray(0.5)
    x, y = left + cut_mm / 2, foot + cut_mm - 1.2 * height
    draw_arrow(canvas, x, y, height)
    canvas.setFont('Helvetica', height * mm)
    canvas.drawString((x + 1.5 * height) * mm, (y + 0.1 * height) * mm, str(tag_id))
    canvas.restoreState()


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


def _draw_ruler(canvas: Canvas, left: float, side_mm: float) -> None:
    """Draw a ruler of RULER_MM at the foot of the page, and the parameter that tells tag_poses the size."""
    foot = MARGIN_MM + 4
    canvas.setLineWidth(0.3)
    canvas.line(left * mm, foot * mm, (left + RULER_MM) * mm, foot * mm)
    for tick in range(RULER_MM + 1):
        height = 4 if tick % 10 == 0 else 3 if tick % 5 == 0 else 2
        x = (left + tick) * mm
        canvas.line(x, foot * mm, x, (foot + height) * mm)
    canvas.setFont('Helvetica', 7)
    for tick in range(0, RULER_MM + 1, 10):
        canvas.drawCentredString((left + tick) * mm, (foot + 5) * mm, str(tick))
    check = 'Millimeters. Check with a ruler; if it is off, print again at 100 %, without "fit to page".'
    for number, line in enumerate((check, 'For poses: tag_size:=%g' % (side_mm / 1000))):
        canvas.drawString(left * mm, (MARGIN_MM + 0.5 - 3.2 * number) * mm, line)
