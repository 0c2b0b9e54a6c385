# SPDX-License-Identifier: GPL-3.0-or-later
"""Keys of connections that leave the machine (CURVE, elliptic-curve encryption of ZeroMQ); `coupler keygen` makes them."""

import os
import re
import stat

_KEY = re.compile(r"[0-9a-zA-Z.\-:+=^!/*?&<>()\[\]{}@%$#]{40}")


class KeyProblem(Exception):
    """A key that is missing, malformed, or open to others."""


def stays_on_this_machine(endpoint):
    """Whether nobody on another machine can reach the endpoint: ipc, and TCP on a loopback address."""
    if endpoint.startswith(("ipc://", "inproc://")):
        return True
    host = endpoint[len("tcp://") :].rpartition(":")[0] if endpoint.startswith("tcp://") else ""
    return host in ("localhost", "[::1]") or re.fullmatch(r"127\.[0-9.]+", host) is not None


def is_key(text):
    return _KEY.fullmatch(text) is not None


def read_pair(file):
    """Public and secret half of a .key file. Raises KeyProblem."""
    try:
        if os.stat(file).st_mode & (stat.S_IRWXG | stat.S_IRWXO):
            raise KeyProblem(f"others may read the key {file}: chmod 600 it")
        with open(file, encoding="utf-8") as stream:
            words = dict(line.rstrip("\n").partition(" ")[::2] for line in stream if not line.startswith("# "))
    except OSError as error:
        raise KeyProblem(f'cannot read the key "{file}": {error.strerror}') from error
    pair = words.get("public", ""), words.get("secret", "")
    if not all(map(is_key, pair)):
        raise KeyProblem(f"{file} holds no secret key: coupler keygen makes such files")
    return pair


def use(socket, endpoint, key_file, coupler_key):
    """Makes a participant's socket speak to the coupler that holds the secret half of `coupler_key`. Without keys only a
    coupler on this machine is spoken to. Raises KeyProblem."""
    if not coupler_key:
        if stays_on_this_machine(endpoint):
            return
        raise KeyProblem(
            f"{endpoint} is not on this machine, and there are no keys: set DROGUE_COUPLER_KEY to the coupler's public key "
            "and DROGUE_KEY to the file of this participant's own (coupler keygen makes them)"
        )
    if not is_key(coupler_key):
        raise KeyProblem("DROGUE_COUPLER_KEY is not a key of 40 characters")
    public, secret = read_pair(key_file)
    socket.curve_serverkey = coupler_key.encode()
    socket.curve_publickey, socket.curve_secretkey = public.encode(), secret.encode()
