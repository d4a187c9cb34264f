#!/usr/bin/env python3
"""Draw docs/images/test_card.png: what camera_demo publishes.

./ci/exec docs/make_camera_picture.py
"""

from pathlib import Path

import numpy
from matplotlib.image import imsave

from parameters_demo.picture import HEIGHT, WIDTH, Picture

data = Picture("front_facing_camera").draw(1234, 1234 / 60)
card = numpy.frombuffer(data, numpy.uint8).reshape(HEIGHT, WIDTH, 3)
path = Path(__file__).parent / "images" / "test_card.png"
imsave(path, card, metadata={"Software": ""})
