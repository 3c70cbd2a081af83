"""What to say of an error of OpenCV's own, whose messages tell of its source and not of the learner's."""
from __future__ import annotations

import re

from .shapes import Values, arrays_of, fit_of

UNEQUAL = (r'Sizes of input arguments do not match|StsUnmatchedSizes|neither .array op array|'
           r'have different types|src1\.size|size\(\) == ')
NUMBERS = 'int', 'float', 'int32', 'int64', 'float32', 'float64'
DRAWN = 'drawContours', 'fillPoly', 'polylines', 'fillConvexPoly'
IN = re.compile(r"in function '?([\w:]+)'?")


def of_opencv(message: str, source: str, values: Values) -> str:
    """The sentence for a cv2.error. ``source``: the line of the file. ``values``: what its names have."""
    text = ' '.join(message.split())
    match = IN.search(text)
    written = re.findall(r'(?:cv2|aruco)\.([a-z]\w*)\(', source)
    function = written[0] if len(written) == 1 else match.group(1).split('::')[-1] if match else ''
    what = of_values(function, text, source, values)
    if what:
        return what
    for pattern, what in SENTENCES:
        if re.search(pattern, function + ': ' + text):
            return what % {'name': 'cv2.' + function if function else 'OpenCV'}
    return 'OpenCV refuses this%s. It says: %s.' % (' in ' + function if function else '', short(text))


def of_values(function: str, text: str, source: str, values: Values) -> str:
    """What the values of the line tell of the error, or ''."""
    if re.search(UNEQUAL, text):
        fit = fit_of(values)
        return 'the two images do not fit together: %s' % fit if fit else ''
    if re.search("'(center|pt1|pt2|org)'", text):
        for name, what in arrays_of(values).items():
            if what['shape'][-2:] == [4, 2]:
                return ('%s has four points, and here one is needed, as two whole numbers: (int(x), int(y)).'
                        % name)
    if function in DRAWN:
        return of_points(function, source, values)
    for name, what in values.items():
        if function in ('warpPerspective', 'warpAffine', 'perspectiveTransform') and what['type'] == 'tuple' \
                and what['length'] == 2 and what['items'][0].get('shape') == [3, 3]:
            return ('%s has two things in it, since cv2.findHomography returns two: "%s, status '
                    '= …".' % (name, name))
        if function == 'drawDetectedMarkers' and name == 'ids' and what['type'] in ('tuple', 'list'):
            return ('what is called ids here is a list of corners. detectMarkers returns three things, in '
                    'the order corners, ids, rejected.')
    return ''


def of_points(function: str, source: str, values: Values) -> str:
    """What is wrong with the points that are drawn, or ''."""
    for name, what in values.items():
        shape, items = what.get('shape', []), what.get('items', [])
        shapes = [item['shape'] for item in items if 'shape' in item]
        as_points = re.search(r'np\.\w+\(\[?%s\b' % name, source) is not None
        if (len(shape) == 1 and shape != [2]) or (items and all(item['type'] in NUMBERS for item in items)):
            return ('%s has %d numbers in it, and no points. If they are places in the list of centers, as '
                    'argmin gives them, take the centers there: centers[%s].'
                    % (name, shape[0] if shape else what['length'], 'places' if name == 'centers' else name))
        if as_points and len(shape) == 2 and shape[1] != 2:
            return ('%s has the shape %s, but points have (…, 2): each its x and its y. Were means taken along '
                    'the wrong axis? quad.mean(axis=0) is the center, if quad has the shape (4, 2).'
                    % (name, tuple(shape)))
        if shape == [2]:
            return '%s is one point alone. A polygon is an array of all four, of shape (4, 2).' % name
        if as_points and shapes and shapes[0] not in ([2], [1, 2]):
            return ('each of %s has the shape %s, but a point has (2,): its x and its y. quad[0].mean(axis=0) '
                    'is the center of a tag, if quad is one of the corners that detectMarkers gives.'
                    % (name, tuple(shapes[0])))
        if shape[-1:] == [2]:
            if 'float' in source:
                continue
            if 'int32' in source or 'int)' in source or what['dtype'] in ('int32', 'int64'):
                if '[%s' % name in source or '[np.' in source:
                    continue
                return ('cv2.%s wants a list of polygons, with brackets around each: [np.int32(%s)].'
                        % (function, name))
            return ('cv2.%s wants whole numbers, of int32, and %s is of %s: [np.int32(%s)].' % (
                function, name, what['dtype'], name))
        if as_points and shapes and '[np.' not in source:
            return ('cv2.%s wants a list of polygons, with brackets around each: [np.int32(%s)].'
                    % (function, name))
    return ''


def short(text: str) -> str:
    """The part of OpenCV's message that says what was wrong."""
    text = re.sub(r'^OpenCV\([^)]*\) *(\S*:-?\d+: )?(error: )?', '', text)
    text = re.sub(r'^\(-?\d+:([^)]*)\) *', r'\1: ', text)
    text = re.sub(r'> Overload resolution failed: *', '', text)
    text = re.sub(r"in function '?[\w:]+'? *", '', text)
    text = re.sub(r': \{anonymous\}.*', '', text)
    parts = []
    for said in re.split(r' > - ', ' ' + text):  # the same is said of each overload
        part = said.strip(' >-:')
        if part and part not in parts:
            parts.append(part)
    return '; '.join(parts[:2])[:200].rstrip(' .:')


NO_SCREEN = ('there is no screen to show a window on. Publish the image instead, and look at it with '
             'rqt_image_view.')
SENTENCES = (
    (r'function is not implemented|cvShowImage|cvNamedWindow|can.t initialize GTK|could not connect to display',
     NO_SCREEN),
    (r'^imwrite.*empty',
     '%(name)s got no image to write: it is None, or empty. Does the function that made it return it?'),
    (r'sidePixels',
     ('the tag would be smaller than its cells. The order is (dictionary, id, size): are id and size '
      'exchanged?')),
    (r'(generateImageMarker|drawMarker).*(id|rows)',
     'the dictionary has no tag of this id. DICT_6X6_250 has 0 to 249.'),
    (r'Failed to allocate|OutOfMemory|Insufficient memory',
     '%(name)s needs more memory than the 1 GB that it may have. Look at the size that it gets.'),
    (r'!_src\.empty\(\)|!src\.empty\(\)|\.empty\(\)|_img\.empty',
     ('%(name)s got an empty image. Where does it come from: was its file found, or is a part of an image '
      'cut out that lies outside?')),
    ((r'(drawContours_?|fillPoly|polylines|fillConvexPoly|contourArea|boundingRect|pointPolygonTest|'
      r'minAreaRect|convexHull|isContourConvex).*'
      r'(npoints >= 0|CV_32S|depth|checkVector|total)|npoints >= 0|checkVector\(2, CV_32S\)'),
     ('the points that %(name)s draws must be whole numbers of 32 bits, a list of arrays: '
      '[np.int32(points)].')),
    ((r"contours.*(wrong type|not a sequence|Can't parse|is not a numerical tuple)|"
      r"(drawContours|polylines|fillPoly).*(Can't parse|Expected|not a)"),
     '%(name)s wants a list of arrays of points: [np.int32(points)], with the brackets.'),
    (r"Can't parse '(center|pt1|pt2|org)'|argument '?(center|pt1|pt2|org)",
     'a point must be a tuple of two whole numbers: (int(x), int(y)).'),
    (r"Can't parse '(dsize|ksize|size)'|argument '?(dsize|ksize)",
     'a size must be a tuple of two whole numbers, the width first: (int(width), int(height)).'),
    (r"Can't parse '(color|fontColor)'|Scalar value for argument '(color)'",
     'a color must be three numbers from 0 to 255: (blue, green, red).'),
    (r'scn is|Invalid number of channels in input image',
     ('%(name)s gets an image with a number of channels that does not fit: is it gray already, or is it '
      'colored where a gray one is needed?')),
    ((r'Sizes of input arguments do not match|size.*same|StsUnmatchedSizes|\(src1\.size|arithm_op|'
      r'neither .array op array.'),
     ('%(name)s needs two images of the same size and the same number of channels. print(image.shape, '
      'mask.shape) shows them. A gray mask becomes one of three channels with cv2.merge([mask, mask, '
      'mask]).')),
    ((r'(findHomography|getPerspectiveTransform).*(npoints|checkVector|count|total|src|Input)|'
      r'at least 4|calibration.*>= 4|The input arrays should be 2D or 3D point sets|'
      r'src\.checkVector\(2, CV_32F\) == 4'),
     ('%(name)s needs as many points on both sides, four each, as arrays of 4 x 2 numbers of float32: '
      'np.float32(points).')),
    (r'warpPerspective.*(M0|matrix|rows == 3)|\(M0\.type|M0\.rows',
     ('cv2.warpPerspective needs a matrix of 3 x 3, as findHomography returns it first, and status second. '
      'getAffineTransform makes one of 2 x 3, which cannot show a slanted wall.')),
    (r"detectMarkers.*'(corners|ids)'",
     ('the third argument of cv2.aruco.detectMarkers is not the parameters. Name them: '
      'parameters=parameters.')),
    (r'Expected cv::aruco::Dictionary',
     ('%(name)s wants the dictionary first. Are arguments exchanged? It is generateImageMarker(dictionary, id, '
      'size), and ArucoDetector(dictionary, parameters).')),
    (r"putText.*'text'", '%(name)s writes a text, and a number is none: str(number) makes one of it.'),
    (r'_in\.channels\(\)|in\.channels\(\) == 1|detectMarkers.*channel',
     'the search for tags needs a gray or a colored image of uint8.'),
    (r'drawDetectedMarkers.*(ids|corners) is not ',
     ('drawDetectedMarkers takes the image, the corners and the ids. detectMarkers returns corners, ids and '
      'rejected candidates, in this order.')),
    (r'drawDetectedMarkers|_corners\.total\(\) == _ids\.total',
     'drawDetectedMarkers needs a colored image, and as many ids as corners.'),
    (r'Expected Ptr<cv::UMat>|is not a numpy array|Expected cv::UMat',
     ('%(name)s got something that is no array where it needs an image or points. np.array(…) makes one of '
      'a list; is something None?')),
    (r'data type = (\w+) is not supported|is not supported|Unsupported (depth|combination)|depth\(\)',
     '%(name)s cannot use numbers of this kind. Images are np.uint8, points np.float32 or np.int32.'),
    (r'could not find a writer', 'OpenCV knows images by the end of their names: .jpg or .png is missing.'),
    ((r'required argument|missing required|takes (at most|exactly)|Unknown argument|not a keyword|'
      r'unexpected keyword'),
     'the arguments of %(name)s do not fit.'),
)
