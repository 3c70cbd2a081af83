"""What the command line of artag_generator.py does besides drawing tags: its options, SVG files and sheets."""
import argparse
import os
import sys

from aruco_ar import InputError
from aruco_ar.base.files import own_folder, write_whole
from aruco_ar.base.progress import progress
from aruco_ar.tags.sheet import PAGES, tag_sheet, tag_svg, tags_around_picture
from aruco_ar.tags.tag import DICTIONARY_NAMES, check_tag

CALLED = 'artag_generator.py'
MAX_ID = 10000  # no dictionary has an id above this


def read_ids(text):
    """The ids in a text such as "1-4" or "1,4,7-9"."""
    ids: list[int] = []
    for part in text.split(','):
        first, dash, last = part.partition('-')
        try:
            begin, end = int(first), int(last if dash else first)
        except ValueError:
            raise argparse.ArgumentTypeError('"%s" is not a list of ids; write for example 1-4 or 1,4,7'
                                             % text) from None
        if begin > end:
            raise argparse.ArgumentTypeError('"%s" contains no id; write the smaller number first' % part)
        if end > MAX_ID:
            raise argparse.ArgumentTypeError('no dictionary has an id above %d, so there is no tag %d'
                                             % (MAX_ID, end))
        ids.extend(range(begin, end + 1))
    return list(dict.fromkeys(ids))


def parse(argv, description, called):
    parser = argparse.ArgumentParser(
        prog=called, description=description, formatter_class=argparse.RawDescriptionHelpFormatter,
        epilog='dictionaries:\n  ' + '\n  '.join(DICTIONARY_NAMES))
    option = parser.add_argument
    option('--dictionary', default='DICT_6X6_250', help='one of those below (default: DICT_6X6_250)')
    option('--ids', type=read_ids, default=[1, 2, 3, 4], help='such as 1-4 or 1,4,7 (default: 1-4)')
    option('--size', type=int,
           help='side of the tag in pixels, in a jpg or png (default: 700)')
    option('--border', type=int, default=1, help='width of the black border in cells (default: 1); '
                                                 'tell the nodes another width by border:=')
    option('--quiet', type=int, help='width of the white margin around the tag in cells '
                                     '(default: 0; 1 on a sheet)')
    option('--format', choices=['jpg', 'png', 'svg'],
           help='file format of the tags, but for a sheet; an svg has its size in millimeters (default: jpg)')
    option('--output', metavar='FOLDER',
           help="folder to write to, but for a sheet (default: the package's Tags/, or ./Tags)")
    option('--sheet', metavar='FILE.pdf', help='write pages to print instead of pictures')
    option('--page', choices=list(PAGES), help='paper for the sheet (default: A4)')
    option('--side', type=float, metavar='MM',
           help='side of the tags on a sheet or in an svg, in millimeters (default: 75, four a page; 50 around '
                'a picture)')
    option('--around-picture', action='store_true',
           help='make the sheet a single page to put up as it is, with a tag in each corner')
    args = parser.parse_args(argv)
    if args.sheet is not None and not args.sheet.lower().endswith('.pdf'):
        parser.error('--sheet takes the name of a PDF file, such as tags.pdf, not "%s"' % args.sheet)
    if args.output == '':
        parser.error('--output takes the name of a folder, not ""')
    if args.around_picture and not args.sheet:
        parser.error('--around-picture is for a sheet. Give the name of its file, too: --sheet tags.pdf')
    refuse_unused(parser, args)
    for name, value in (('size', 700), ('side', 50 if args.around_picture else 75), ('format', 'jpg'),
                        ('page', 'A4'), ('quiet', 1 if args.sheet else 0)):
        if getattr(args, name) is None:
            setattr(args, name, value)
    return args


def refuse_unused(parser, args):
    """End with a sentence if an option is given that has no effect on what is to be written."""
    is_svg = args.format == 'svg'
    for name, is_used, where in (
            ('size', not (args.sheet or is_svg), 'a jpg or png; the side on a sheet or in an svg is --side MM'),
            ('side', args.sheet or is_svg, 'a sheet or an svg; the side in a jpg or png is --size PIXELS'),
            ('page', args.sheet, 'a sheet. Give the name of its file, too: --sheet tags.pdf'),
            ('format', not args.sheet, 'single tags; a sheet is always a PDF'),
            ('output', not args.sheet, 'single tags; write the folder of a sheet before its name: --sheet %s'
             % os.path.join(args.output or '', os.path.basename(args.sheet or '')))):
        if getattr(args, name) is not None and not is_used:
            parser.error('--%s is for %s' % (name, where))


def files_of(args, draw_files):
    """(path, bytes) of each file. All are drawn before any is written, in case one of them is impossible."""
    if args.sheet:
        draw_pages = tags_around_picture if args.around_picture else tag_sheet
        return [(args.sheet, draw_pages(args.dictionary, args.ids, args.side, args.page, args.border,
                                        args.quiet))]
    if args.format == 'svg':
        draw_files = svg_files
    else:
        for tag_id in args.ids:
            check_tag(args.dictionary, tag_id, args.size, args.border, args.quiet)
    folder = args.output or own_folder('Tags')
    return [(os.path.join(folder, name), data)
            for name, data in progress(draw_files(args), 'tags', len(args.ids))]


def svg_files(args):
    """(name, bytes) of the file of each tag."""
    for tag_id in args.ids:
        yield 'image_%d.svg' % tag_id, tag_svg(args.dictionary, tag_id, args.side, args.border,
                                               args.quiet).encode()


def run(draw_files, description, argv, called=CALLED):
    """Do what the command line says; end with a sentence if that is impossible.

    ``draw_files``: takes the options, and yields (name, bytes) of each picture. ``description``: for --help.
    ``called``: how this program is started.
    """
    # roslaunch adds arguments of its own, such as __name:=..., which are ignored here.
    args = parse([arg for arg in argv if not arg.startswith('__')], description, called)
    try:
        for path, data in files_of(args, draw_files):
            write_whole(path, data)
            print('Wrote %s' % os.path.abspath(path))
    except InputError as error:
        sys.exit('%s: %s' % (os.path.splitext(called)[0], error))
