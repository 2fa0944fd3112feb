"""mavlink_peer.py PROGRAM: our MAVLink against pymavlink, an implementation of others: every message in both directions,
a whole conversation over a pseudo-terminal, and signatures. Field by field, in NED, by hand."""
import math
import os
import select
import subprocess
import sys
import time
import tty

from pymavlink.dialects.v20 import development as mavlink  # common, and CURRENT_MODE

PROGRAM = sys.argv[1]
CHECKS = 0


def check(claim, holds):
    global CHECKS
    CHECKS += 1
    if not holds:
        sys.exit(f"FAILED: {claim}")


def near(a, b, tolerance=1e-5):
    return abs(a - b) <= tolerance


# ---- Every message: the fields that we carry, in the order in which the program prints them.
POSE = ["x", "y", "z", "vx", "vy", "vz"]
TARGET = ["target_system", "target_component"]
SETPOINT = ["type_mask", *POSE, "afx", "afy", "afz", "yaw", "yaw_rate"]
FIELDS = {
    "heartbeat": ["custom_mode", "type", "autopilot", "base_mode", "system_status"],
    "sys_status": ["onboard_control_sensors_present", "onboard_control_sensors_enabled",
                   "onboard_control_sensors_health", "voltage_battery", "battery_remaining"],
    "param_request_read": [*TARGET, "param_id", "param_index"],
    "param_request_list": TARGET,
    "param_value": ["param_id", "param_value", "param_type", "param_count", "param_index"],
    "param_set": [*TARGET, "param_id", "param_value", "param_type"],
    "attitude_quaternion": ["time_boot_ms", "q1", "q2", "q3", "q4", "rollspeed", "pitchspeed", "yawspeed"],
    "local_position_ned": ["time_boot_ms", *POSE],
    "command_int": [*TARGET, "frame", "command", "param1", "param2", "param3", "param4", "x", "y", "z"],
    "command_long": [*TARGET, "command", "confirmation", *(f"param{i}" for i in range(1, 8))],
    "command_ack": ["command", "result", *TARGET],
    "set_attitude_target": ["time_boot_ms", *TARGET, "type_mask", "q", "body_roll_rate", "body_pitch_rate",
                            "body_yaw_rate", "thrust"],
    "set_position_target_local_ned": ["time_boot_ms", *TARGET, "coordinate_frame", *SETPOINT],
    "position_target_local_ned": ["time_boot_ms", "coordinate_frame", *SETPOINT],
    "timesync": ["tc1", "ts1"],
    "extended_sys_state": ["landed_state"],
    "statustext": ["severity", "text", "id", "chunk_seq"],
    "odometry": ["time_usec", "frame_id", "child_frame_id", "x", "y", "z", "q", "vx", "vy", "vz", "rollspeed",
                 "pitchspeed", "yawspeed", "reset_counter"],
    "current_mode": ["standard_mode", "custom_mode", "intended_custom_mode"],
}


def message_class(name):
    return next(c for c in mavlink.mavlink_map.values() if c.msgname == name.upper())


def sample(name):
    """A message whose fields all differ."""
    kind = message_class(name)
    values = []
    for i, field in enumerate(kind.fieldnames):
        ctype = kind.fieldtypes[kind.fieldnames.index(field)]
        length = kind.array_lengths[kind.ordered_fieldnames.index(field)]
        if ctype == "char":
            values.append(f"TEXT_{i}".encode())
        elif length > 0:
            values.append([0.5 + i + 0.125 * k for k in range(length)])
        elif ctype in ("float", "double"):
            values.append(-1.5 + 0.25 * i)
        else:
            values.append({"result": 1, "landed_state": 2}.get(field, i + 1))
    return kind(*values)


def flat(value):
    if isinstance(value, list):
        return [float(v) for v in value]
    return [value.rstrip("\0") if isinstance(value, str) else float(value)]


def check_every_message():
    sender = mavlink.MAVLink(None, srcSystem=1, srcComponent=1)
    samples = {name: sample(name) for name in FIELDS}
    bytes_in = b"".join(message.pack(sender) for message in samples.values())
    result = subprocess.run([PROGRAM, "codec"], input=bytes_in, capture_output=True, timeout=60)
    check("the program understood every byte", result.returncode == 0)
    lines = result.stderr.decode().splitlines()
    echoes = mavlink.MAVLink(None).parse_buffer(result.stdout) or []
    check("every message came back", len(lines) == len(echoes) == len(samples))
    for (name, message), line, echo in zip(samples.items(), lines, echoes):
        check(f"{name}: its number", int(line.split()[0]) == message.get_msgId() == echo.get_msgId())
        check(f"{name}: the sender", (echo.get_srcSystem(), echo.get_srcComponent()) == (1, 195))
        expected = [v for field in FIELDS[name] for v in flat(getattr(message, field))]
        got = line.split()[1:]
        check(f"{name}: {got} is {expected}", len(got) == len(expected) and all(
            g == e if isinstance(e, str) else near(float(g), e, 1e-6 * max(1, abs(e))) for g, e in zip(got, expected)))
        for field in FIELDS[name]:
            check(f"{name}.{field} came back", flat(getattr(echo, field)) == flat(getattr(message, field)))


# ---- A conversation: we are the autopilot, and now and then a ground station.
class Conversation:
    def __init__(self, key_byte=None):
        self.line, far_end = os.openpty()
        tty.setraw(self.line)
        arguments = [PROGRAM, "link", os.ttyname(far_end)]
        if key_byte is not None:
            arguments.append(str(key_byte))
        self.program = subprocess.Popen(arguments, stdout=subprocess.PIPE, text=True)
        self.autopilot = mavlink.MAVLink(self, srcSystem=1, srcComponent=1)
        self.station = mavlink.MAVLink(self, srcSystem=255, srcComponent=190)
        self.parser = mavlink.MAVLink(None)
        self.parser.robust_parsing = True
        self.heard = []
        self.lines = []
        self.rates = {}
        check("the program is ready", self.program.stdout.readline().strip() == "ready")
        os.set_blocking(self.program.stdout.fileno(), False)

    def write(self, data):
        os.write(self.line, data)

    def listen(self, until, what, seconds=20):
        """Answers as an autopilot does until `until` returns something that is true."""
        end = time.monotonic() + seconds
        while time.monotonic() < end:
            ready, _, _ = select.select([self.line, self.program.stdout], [], [], 0.05)
            if self.line in ready:
                for message in self.parser.parse_buffer(os.read(self.line, 4096)) or []:
                    self.take(message)
            if self.program.stdout in ready:
                self.lines += self.program.stdout.read().splitlines()
            found = until()
            if found:
                return found
        print("\n".join(self.lines + [str(m) for m in self.heard][-20:]))
        return sys.exit(f"FAILED: waited for {what}")

    def take(self, message):
        self.heard.append(message)
        if message.get_type() == "TIMESYNC" and message.tc1 == 0:
            self.autopilot.timesync_send(time.monotonic_ns() + 5_000_000_000, message.ts1)
        if message.get_type() == "COMMAND_LONG" and message.command == mavlink.MAV_CMD_SET_MESSAGE_INTERVAL:
            self.rates[int(message.param1)] = message.param2
            self.autopilot.command_ack_send(message.command, 0, 0, 0, 1, 195)

    def hear(self, kind, accept=lambda m: True):
        def find():
            for i, message in enumerate(self.heard):
                if message.get_type() == kind and accept(message):
                    return self.heard.pop(i)
            return None
        return self.listen(find, kind)

    def read(self, word):
        def find():
            for i, line in enumerate(self.lines):
                if line.split()[0] == word:
                    return self.lines.pop(i)
            return None
        return self.listen(find, f"line {word}")

    def order(self, action):
        """A command of a ground station that the program carries out; its acknowledgement."""
        self.station.command_long_send(1, 195, 31010, 0, action, 0, 0, 0, 0, 0, 0)
        self.read("command_long")
        ack = self.hear("COMMAND_ACK")
        check("the acknowledgement goes to who asked", (ack.target_system, ack.target_component) == (255, 190))
        return ack.result

    def say_heartbeat(self, main_mode, armed=False):
        flags = mavlink.MAV_MODE_FLAG_CUSTOM_MODE_ENABLED | (mavlink.MAV_MODE_FLAG_SAFETY_ARMED if armed else 0)
        self.autopilot.heartbeat_send(mavlink.MAV_TYPE_QUADROTOR, mavlink.MAV_AUTOPILOT_PX4, flags, main_mode << 16, 3)

    def end(self):
        self.station.command_long_send(1, 195, 31010, 0, 99, 0, 0, 0, 0, 0, 0)
        counters = [float(v) for v in self.read("counters").split()[1:]]
        check("the program ends well", self.program.wait(20) == 0)
        os.close(self.line)
        return counters


def check_conversation():
    talk = Conversation()
    heartbeat = talk.hear("HEARTBEAT")
    check("heartbeat", (heartbeat.type, heartbeat.autopilot, heartbeat.get_srcSystem(), heartbeat.get_srcComponent())
          == (mavlink.MAV_TYPE_ONBOARD_CONTROLLER, mavlink.MAV_AUTOPILOT_INVALID, 1, 195))
    talk.say_heartbeat(3)
    talk.listen(lambda: len(talk.rates) >= 14, "message rates")
    check("rates", talk.rates[32] == 20000 and talk.rates[31] == 10000 and talk.rates[105] == -1)
    talk.read("synchronised")
    talk.autopilot.timesync_send(0, 4242)
    check("our answer to TIMESYNC", talk.hear("TIMESYNC", lambda m: m.ts1 == 4242).tc1 > 0)

    # 1 north, 2 east, 3 down, to the north; facing north: ours is 2, 1, -3 and 90 degrees.
    talk.autopilot.local_position_ned_send(1000, 1, 2, 3, 4, 5, 6)
    talk.autopilot.attitude_quaternion_send(1000, 1, 0, 0, 0, 0.1, 0.2, 0.3)
    check("vehicle asked for", talk.order(8) == 0)
    half = math.sqrt(0.5)
    values = [float(v) for v in talk.read("vehicle").split()[1:]]
    expected = [2, 1, -3, 5, 4, -6, half, 0, 0, half, 0.1, -0.2, -0.3]
    check(f"vehicle {values}", all(near(a, b) for a, b in zip(values, expected)))

    # The map: here is (10, 20, 30), and where the vehicle faces (north) is the map's x. 9 back, 18 right, 27 down of here.
    check("aligned", talk.order(7) == 0)
    check("position set-point", talk.order(3) == 0)
    target = talk.hear("SET_POSITION_TARGET_LOCAL_NED")
    got = [target.x, target.y, target.z, target.vx, target.vy, target.vz, target.afx, target.afy, target.afz,
           target.yaw, target.yaw_rate]
    expected = [1 - 9, 2 + 18, 3 + 27, 4, -5, -6, 7, -8, -9, 0, -1]
    check(f"position set-point {got}", all(near(a, b) for a, b in zip(got, expected)))
    check("its frame and target", (target.coordinate_frame, target.type_mask, target.target_system,
                                   target.target_component) == (mavlink.MAV_FRAME_LOCAL_NED, 0, 1, 1))
    check("attitude set-point", talk.order(4) == 0)
    target = talk.hear("SET_ATTITUDE_TARGET")
    check(f"level, facing north: {target.q}", near(abs(target.q[0]), 1) and near(target.thrust, 0.5) and
          target.type_mask == 7)
    check("rate set-point", talk.order(5) == 0)
    target = talk.hear("SET_ATTITUDE_TARGET")
    check("rates", [target.body_roll_rate, target.body_pitch_rate, target.body_yaw_rate] == [1, -2, -3] and
          target.thrust == 0.25 and target.type_mask == 128)

    talk.autopilot.odometry_send(1_000_000, mavlink.MAV_FRAME_LOCAL_NED, mavlink.MAV_FRAME_BODY_FRD, 1, 2, 3,
                                 [half, 0, 0, half], 1, 0, 0, 0, 0, 0, [math.nan] * 21, [math.nan] * 21, 3, 0)
    check("vehicle asked for", talk.order(8) == 0)
    values = [float(v) for v in talk.read("vehicle").split()[1:]]
    check(f"odometry {values}", all(near(a, b) for a, b in zip(values, [10, 20, 30, 0, -1, 0])))  # east is the right

    # A change of mode with PX4's two acknowledgements, then one that is seen; arming.
    check("mode", talk.order(1) == 0)
    command = talk.hear("COMMAND_LONG", lambda m: m.command == mavlink.MAV_CMD_DO_SET_MODE)
    check("its parameters", (command.param1, command.param2, command.param3) == (1, 6, 0))
    talk.autopilot.command_ack_send(command.command, 0, 0, 0, 1, 195)
    talk.autopilot.command_ack_send(command.command, 1, 0, 0, 1, 195)
    check("the second counts", talk.read("outcome").split()[1:] == ["176", "1", "1"])
    check("mode", talk.order(1) == 0)
    talk.hear("COMMAND_LONG", lambda m: m.command == mavlink.MAV_CMD_DO_SET_MODE)
    talk.autopilot.command_ack_send(command.command, 0, 0, 0, 1, 195)
    talk.autopilot.current_mode_send(0, 6 << 16, 6 << 16)
    check("seen", talk.read("outcome").split()[1:] == ["176", "0", "0"])
    check("arming", talk.order(2) == 0)
    command = talk.hear("COMMAND_LONG", lambda m: m.command == mavlink.MAV_CMD_COMPONENT_ARM_DISARM)
    check("repeated", talk.hear("COMMAND_LONG", lambda m: m.command == 400).confirmation == command.confirmation + 1)
    talk.autopilot.command_ack_send(400, 0, 0, 0, 1, 195)
    check("armed", talk.read("outcome").split()[1:] == ["400", "0", "0"])

    # Parameters, texts, goals, the other form of a command.
    talk.station.param_request_list_send(1, 0)
    value = talk.hear("PARAM_VALUE", lambda m: m.param_index == 1)
    check("listed", (value.param_id, value.param_value, value.param_count, value.param_type) == ("RADIUS", 0.25, 2, 9))
    talk.station.param_set_send(1, 195, b"SPEED_MAX", 2.5, mavlink.MAV_PARAM_TYPE_REAL32)
    check("set", talk.hear("PARAM_VALUE", lambda m: m.param_value == 2.5).param_id == "SPEED_MAX")
    talk.station.param_request_read_send(1, 195, b"SPEED_MAX", -1)
    check("read", talk.hear("PARAM_VALUE", lambda m: m.param_value == 2.5).param_id == "SPEED_MAX")
    talk.autopilot.statustext_send(4, b"Arming denied")
    check("text", talk.read("text") == "text 4 Arming denied")
    check("text of ours", talk.order(6) == 0)
    first = talk.hear("STATUSTEXT")
    second = talk.hear("STATUSTEXT")
    check("in two pieces", first.text + second.text == "A text that is longer than the fifty characters of one message"
          and first.id == second.id != 0 and (first.chunk_seq, second.chunk_seq, first.severity) == (0, 1, 5))
    mask = 0b1001_1111_1000  # position and yaw
    talk.station.set_position_target_local_ned_send(0, 1, 195, mavlink.MAV_FRAME_LOCAL_NED, mask, 1 - 9, 2 + 18, 3 + 27,
                                                    0, 0, 0, 0, 0, 0, 0.5, 0)
    values = [float(v) for v in talk.read("goal").split()[1:]]
    check(f"goal {values}", all(near(a, b) for a, b in zip(values, [1, 2, 3, -0.5])))
    talk.station.command_int_send(1, 195, 6, mavlink.MAV_CMD_DO_REPOSITION, 0, 0, 1, 2, 3, 4, 473977418, -85, 12.5)
    check("COMMAND_INT", talk.read("command_int").split()[1:]
          == ["192", "1", "2", "3", "4", "0", "0", "12.5", "473977418", "-85", "6"])
    check("not ours to do", talk.hear("COMMAND_ACK").result == mavlink.MAV_RESULT_UNSUPPORTED)
    check("no byte was skipped, no frame lost", talk.end() == [0, 0, 0, 0])


def check_signing():
    talk = Conversation(key_byte=0x42)
    for end in (talk.parser, talk.station):
        end.signing.secret_key = bytes([0x42] * 32)
    talk.parser.signing.allow_unsigned_callback = lambda *_: False  # pymavlink drops what is not signed rightly
    check("our heartbeat is signed", talk.hear("HEARTBEAT").get_signed())
    talk.say_heartbeat(3)
    talk.station.command_long_send(1, 195, 31010, 0, 7, 0, 0, 0, 0, 0, 0)
    check("an unsigned command is denied", talk.hear("COMMAND_ACK").result == mavlink.MAV_RESULT_DENIED)
    talk.station.signing.sign_outgoing = True
    talk.station.signing.timestamp = 1000
    talk.autopilot.local_position_ned_send(1000, 1, 2, 3, 4, 5, 6)
    talk.autopilot.attitude_quaternion_send(1000, 1, 0, 0, 0, 0.1, 0.2, 0.3)
    check("a signed one is done", talk.order(7) == 0)
    talk.station.signing.secret_key = bytes([0x43] * 32)
    talk.station.command_long_send(1, 195, 31010, 0, 99, 0, 0, 0, 0, 0, 0)
    talk.station.signing.secret_key = bytes([0x42] * 32)
    check("none of it was lost", talk.end() == [0, 1, 1, 0])


# ---- What docs/link.md says about load: messages a second, without the streams that PX4 sends besides.
FROM_AUTOPILOT = {"local_position_ned": 50, "attitude_quaternion": 100, "current_mode": 10, "extended_sys_state": 5,
                  "sys_status": 2, "heartbeat": 1, "timesync": 10 + 5}
TO_AUTOPILOT = {"set_attitude_target": 100, "heartbeat": 1, "timesync": 10 + 5}
EXTENSIONS = {"attitude_quaternion": 16, "sys_status": 12}  # zero, so not sent


def print_budget():
    for direction, rates in (("from", FROM_AUTOPILOT), ("to", TO_AUTOPILOT)):
        total = 0
        for name, rate in rates.items():
            size = 12 + message_class(name).unpacker.size - EXTENSIONS.get(name, 0)
            total += size * rate
            print(f"{direction} the autopilot: {name.upper():24} {size:3} B x {rate:3}/s = {size * rate:5} B/s")
        print(f"{direction} the autopilot: {total} B/s, {100 * total / 92160:.1f} % of 921600 baud")


check_every_message()
check_conversation()
check_signing()
print_budget()
print(f"{CHECKS} passed, 0 failed")
