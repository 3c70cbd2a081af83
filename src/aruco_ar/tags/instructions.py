"""A page that says how to hang printed tags."""
from __future__ import annotations

from typing import Sequence

from reportlab.lib.units import mm
from reportlab.pdfgen.canvas import Canvas

MARGIN_MM = 20
LINE_MM = 7
DRAWING_MM = 110, 70  # the area between the centers of the tags
TAG_MM = 24
ARROW_MM = 4

STEPS = (
    'Check with a ruler that the rulers on the pages are right. If not, print again at 100 %.',
    'Cut along the dashed lines. The white margin belongs to the tag: leave it on.',
    'Hang four tags as above: in this order, each with its small arrow up.',
    'The corners of the picture will be at the centers of the tags.',
    'Any distances will do, but the tags must be in one plane, flat, without folds or shine.',
    'In the camera image, a tag should be at least 20 pixels wide. In an image of 640 x 480 pixels, that is',
    'a tag of %(side)g mm from up to %(reach).1f m away. For longer distances, print larger tags: --side.',
    'Use each id only once in sight of the camera.',
    'For the poses of tags and camera, say how large the tags are: tag_size:=%(meters)g')
INDENTED = 6  # this line goes on with the one before
PIXELS, FOCAL_PX = 20, 554  # width of the narrowest tag, and focal length of the ROSbot's camera


def draw_instructions(canvas: Canvas, width_mm: float, height_mm: float, ids: Sequence[int],
                      side_mm: float) -> None:
    """Draw a page of that size. ``ids``: those on the pages before it. ``side_mm``: the side of the tags."""
    y = height_mm - MARGIN_MM
    canvas.setFont('Helvetica-Bold', 16)
    canvas.drawString(MARGIN_MM * mm, y * mm, 'How to hang the tags')
    left, top = (width_mm - DRAWING_MM[0]) / 2, y - 18 - TAG_MM / 2
    _draw_wall(canvas, left, top, [str(tag_id) for tag_id in ids[:4]] if len(ids) >= 4 else list('1234'))
    y = top - DRAWING_MM[1] - TAG_MM - 12
    values = {'side': side_mm, 'meters': side_mm / 1000, 'reach': side_mm / 1000 * FOCAL_PX / PIXELS}
    number = 0
    for index, step in enumerate(STEPS):
        canvas.setFont('Helvetica', 11)
        if index != INDENTED:
            number += 1
            canvas.drawString(MARGIN_MM * mm, y * mm, '%d.' % number)
        canvas.drawString((MARGIN_MM + 8) * mm, y * mm, step % values if '%(' in step else step)
        y -= LINE_MM
    canvas.showPage()


def _draw_wall(canvas: Canvas, left: float, top: float, ids: Sequence[str]) -> None:
    right, foot = left + DRAWING_MM[0], top - DRAWING_MM[1]
    canvas.saveState()
    canvas.setFillGray(0.92)
    canvas.rect(left * mm, foot * mm, DRAWING_MM[0] * mm, DRAWING_MM[1] * mm, fill=1, stroke=0)
    canvas.setFillGray(0.3)
    canvas.setFont('Helvetica', 13)
    canvas.drawCentredString((left + right) / 2 * mm, (top + foot) / 2 * mm, 'picture')
    for text, (x, y) in zip(ids, ((left, top), (right, top), (right, foot), (left, foot))):
        canvas.setFillGray(1)
        canvas.setLineWidth(1)
        canvas.rect((x - TAG_MM / 2) * mm, (y - TAG_MM / 2) * mm, TAG_MM * mm, TAG_MM * mm, fill=1)
        canvas.setFillGray(0)
        canvas.setFont('Helvetica-Bold', 20)
        canvas.drawCentredString(x * mm, (y - 3) * mm, text)
        draw_arrow(canvas, x - ARROW_MM / 2, y + 6, ARROW_MM)
    canvas.restoreState()


def draw_arrow(canvas: Canvas, left: float, foot: float, size: float) -> None:
    """Fill a triangle that points up. All lengths are in millimeters; it is as wide as high."""
    arrow = canvas.beginPath()
    arrow.moveTo(left * mm, foot * mm)
    arrow.lineTo((left + size) * mm, foot * mm)
    arrow.lineTo((left + size / 2) * mm, (foot + size) * mm)
    arrow.close()
    canvas.drawPath(arrow, fill=1, stroke=0)
