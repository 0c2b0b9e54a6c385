# SPDX-License-Identifier: GPL-3.0-or-later
"""The thread that owns a participant's socket."""

import os
import queue
import sys
import threading
import time
import traceback
from collections import deque

import zmq
from zmq.utils.monitor import recv_monitor_message

from drogue import keys, wire

BEAT_INTERVAL = 1.0
# How long a solver that is in the middle of its work may go on after the coupler is gone.
GRACE_WITHOUT_COUPLER = 10.0
SEND_DEADLINE = 30.0
INTERNAL_STATUS = 1
PEER_STATUS = 4


class Lost(Exception):
    """The coupler is gone, silent, or sent something malformed."""


class TransportFailure(Exception):
    """The thread that talks to the coupler failed: a bug, or something handed to it that cannot be sent."""


class Transport:
    """Hands requests to the solver's thread one by one, sends its answers, answers a repeated request from its cache,
    beats while the solver works, and notices when the coupler is gone."""

    def __init__(self, endpoint, participant, run_id, key_file="", coupler_key=""):
        self.endpoint, self.participant, self.run_id = endpoint, participant, run_id
        self._keys = key_file, coupler_key
        self._connected = False  # the coupler has taken the connection, with its keys
        self.progress = ("", 0, 0.0)  # phase, inner iteration, inner residual; replaced as a whole
        self._incoming = queue.Queue()  # requests; None when the coupler is lost
        self._outgoing = deque()
        self._sent = threading.Condition()
        self._stop = threading.Event()
        self._lost = None
        self._lost_at = None
        self._failed = False
        # Used by the thread alone.
        self._working_on = 0
        self._last_request = None
        self._last_answer = None
        self._last_beat = 0.0

    def start(self):
        """Connects and starts the thread. Raises keys.KeyProblem, or Lost."""
        self._context = zmq.Context()
        self._socket = self._context.socket(zmq.DEALER)
        self._socket.setsockopt(zmq.LINGER, 0)
        self._socket.setsockopt(zmq.MAXMSGSIZE, wire.MAX_FRAME_BYTES)
        self._socket.setsockopt(zmq.SNDTIMEO, int(1000 * SEND_DEADLINE))
        self._socket.setsockopt(zmq.IDENTITY, self.participant.encode())
        keys.use(self._socket, self.endpoint, *self._keys)
        self._monitor = self._socket.get_monitor_socket(
            zmq.EVENT_DISCONNECTED
            | zmq.EVENT_HANDSHAKE_SUCCEEDED
            | zmq.EVENT_HANDSHAKE_FAILED_AUTH
            | zmq.EVENT_HANDSHAKE_FAILED_PROTOCOL
        )
        self._wake_out = self._context.socket(zmq.PAIR)
        self._wake_out.bind("inproc://wake")
        self._wake_in = self._context.socket(zmq.PAIR)
        self._wake_in.connect("inproc://wake")
        try:
            self._socket.connect(self.endpoint)
        except zmq.ZMQError as error:
            raise Lost(f'cannot connect to the coupler at "{self.endpoint}": {error}') from error
        self._thread = threading.Thread(target=self._run, name="drogue-transport", daemon=True)
        self._thread.start()

    def close(self):
        """Ends the thread; never waits for the peer longer than a send's deadline."""
        self._stop.set()
        self._wake_in.send(b"")
        self._thread.join()
        self._socket.disable_monitor()
        self._socket.close(linger=0 if self._lost else 2000)  # the last answer must get out
        for socket in (self._monitor, self._wake_in, self._wake_out):
            socket.close(linger=0)
        self._context.term()

    def next_request(self, deadline):
        """Waits passively for the next request, at most `deadline` seconds. Raises Lost, or TransportFailure."""
        try:
            request = self._incoming.get(timeout=deadline)
        except queue.Empty:
            raise Lost(f"the coupler at {self.endpoint} sent nothing for {deadline:g} s") from None
        if request is None:
            raise TransportFailure(self._lost) if self._failed else Lost(self._lost)
        return request

    def post(self, message):
        """Queues a message to the coupler. For the solver's thread."""
        message.envelope.run_id = self.run_id
        message.envelope.participant = self.participant
        self._outgoing.append(message)
        self._wake_in.send(b"")

    def flush(self, deadline):
        """Waits until everything posted was handed to the socket, at most `deadline` seconds."""
        with self._sent:
            self._sent.wait_for(lambda: not self._outgoing or self._lost, deadline)

    def _run(self):
        """The thread. Whatever ends it early is told to the solver's thread; a solver that stays deep in its work, where
        nobody can reach it any more, is not left alone with it for long."""
        try:
            self._loop()
        except Exception as error:
            traceback.print_exc()
            self._failed = True
            self._lose(f"the connection to the coupler failed: {type(error).__name__}: {error}")
            if not self._stop.wait(GRACE_WITHOUT_COUPLER):
                print(f"{self.participant}: no connection any more: leaving in the middle of the work", file=sys.stderr)
                os._exit(INTERNAL_STATUS)

    def _loop(self):
        poller = zmq.Poller()
        for socket in (self._socket, self._wake_out, self._monitor):
            poller.register(socket, zmq.POLLIN)
        while True:
            ready = dict(poller.poll(1000 * BEAT_INTERVAL / 2))
            if self._wake_out in ready:
                self._wake_out.recv()
            self._send_outgoing()
            if self._stop.is_set():
                return
            if self._socket in ready:
                self._receive()
            if self._monitor in ready:
                self._follow_connection(recv_monitor_message(self._monitor)["event"])
            self._beat()
            self._leave_if_abandoned()

    def _follow_connection(self, event):
        if event == zmq.EVENT_HANDSHAKE_SUCCEEDED:
            self._connected = True
        elif event == zmq.EVENT_HANDSHAKE_FAILED_AUTH:
            self._lose("the coupler does not allow this participant's key")
        elif self._connected:
            self._lose("the coupler closed the connection")
        else:
            self._lose("the coupler closed the connection before it was set up: do the keys fit?")

    def _receive(self):
        try:
            request = wire.decode(self._socket.recv_multipart(copy=False))
        except wire.WireError as error:
            self._lose(str(error))
            return
        number = request.envelope.request_id
        if number and number == self._working_on:
            return
        if number and self._last_answer and number == self._last_answer.envelope.request_id:
            self._send(self._last_answer)
            return
        self._working_on = number
        self._last_request = request.envelope
        self.progress = ("", 0, 0.0)
        self._last_beat = time.monotonic()
        self._incoming.put(request)

    def _send_outgoing(self):
        while self._outgoing:
            message = self._outgoing[0]
            self._send(message)
            if message.envelope.request_id:
                self._working_on = 0
                self._last_answer = message
            with self._sent:
                self._outgoing.popleft()
                self._sent.notify_all()

    def _send(self, message):
        try:
            self._socket.send_multipart(wire.encode(message))
        except zmq.ZMQError as error:
            self._lose(f"cannot send: {error}")

    def _beat(self):
        if not self._working_on or time.monotonic() - self._last_beat < BEAT_INTERVAL:
            return
        self._last_beat = time.monotonic()
        message = wire.Message()
        envelope = message.envelope
        envelope.run_id, envelope.participant = self.run_id, self.participant
        envelope.step, envelope.iteration = self._last_request.step, self._last_request.iteration
        envelope.attempt = self._last_request.attempt
        envelope.beat.phase, envelope.beat.inner_iteration, envelope.beat.inner_residual = self.progress
        self._send(message)

    def _lose(self, why):
        if self._lost is None:
            self._lost, self._lost_at = why, time.monotonic()
            self._incoming.put(None)
            with self._sent:
                self._sent.notify_all()

    def _leave_if_abandoned(self):
        """Without a coupler nobody wants the result: a solver deep in its work must not live on as an orphan."""
        if self._lost_at is not None and time.monotonic() - self._lost_at > GRACE_WITHOUT_COUPLER:
            print(f"{self.participant}: the coupler is gone: leaving in the middle of the work", file=sys.stderr)
            os._exit(PEER_STATUS)
