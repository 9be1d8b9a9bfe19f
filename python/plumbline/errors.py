# SPDX-License-Identifier: Apache-2.0

"""What can go wrong. Messages are those of the command `plumb`."""


class Error(Exception):
    """Anything that `plumb` would end with 'trouble' for."""


class ArgumentError(Error, ValueError):
    """An argument that is not what it should be, or contradicts another one."""


class SceneError(Error):
    """What a scene file holds that is wrong or not supported, all of it, with its lines."""


class PictureError(Error):
    """A file that can't be read or written, or a picture that can't be compared: of another size,
    with other channels, or with values that are not finite or negative."""


class Notice(UserWarning):
    """What was taken or chosen otherwise than one might expect, such as an arithmetic in double
    precision that a scene needs."""
