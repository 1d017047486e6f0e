"""cv2.warpPerspective of a picture against a frame of the renderer: render_opencv.py PICTURE FRAME H00 .. H22

H maps pixels of the picture to pixels of the frame. Prints mean and largest difference in parts of full scale over the
pixels whose neighbourhood in the picture is inside it.
"""

import sys

import cv2
import numpy as np

picture = cv2.imread(sys.argv[1], cv2.IMREAD_UNCHANGED).astype(np.float32) / 65535
frame = np.fromfile(sys.argv[2], dtype="<f4").reshape(768, 1024)
homography = np.array([float(v) for v in sys.argv[3:12]]).reshape(3, 3)

expected = cv2.warpPerspective(picture, homography, (1024, 768), flags=cv2.INTER_LINEAR)
inside = cv2.warpPerspective(np.ones_like(picture), homography, (1024, 768), flags=cv2.INTER_NEAREST)
inside = cv2.erode(inside, np.ones((9, 9))) > 0
difference = np.abs(frame - expected)[inside]
print(f"{inside.mean():.4f} {difference.mean():.6f} {difference.max():.6f}")
