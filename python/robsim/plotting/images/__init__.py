"""Drawing on images: camera frames, clips, the image of a robot."""
