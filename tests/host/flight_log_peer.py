"""PX4's own reader opens a flight log that ours wrote: flight_log_peer.py PROGRAM FOLDER."""

import pathlib
import subprocess
import sys
import unittest

import pyulog

STEPS = 100
START = 1_000_000
FOLDER = pathlib.Path()
PROGRAM = ""


class FlightLog(unittest.TestCase):
    @classmethod
    def setUpClass(cls):
        FOLDER.mkdir(parents=True, exist_ok=True)
        subprocess.run([PROGRAM, FOLDER], check=True)
        cls.path = FOLDER / "sample.ulg"
        cls.log = pyulog.ULog(str(cls.path))

    def topic(self, name):
        return self.log.get_dataset(name).data

    def test_is_sound(self):
        self.assertFalse(self.log.file_corruption)
        self.assertEqual(self.log.start_timestamp, START)
        self.assertEqual(self.log.dropouts, [])

    def test_information(self):
        info = self.log.msg_info_dict
        self.assertEqual(info["sys_name"], "swiftlet")
        self.assertEqual(info["ver_sw"], "1.2.3")
        self.assertEqual(info["swiftlet_settings"], '{"a": 1}')
        self.assertEqual(info["swiftlet_map_crc32"], 42)
        self.assertEqual(info["swiftlet_map_file_0000002b"], "/maps/other.swm")  # given under way

    def test_estimate_is_north_east_down(self):
        position = self.topic("vehicle_local_position")
        self.assertEqual(len(position["timestamp"]), STEPS)
        for i in range(STEPS):
            self.assertEqual(position["timestamp"][i], START + 10_000 * i)
            self.assertEqual(position["timestamp_sample"][i], START + 10_000 * i - 4_000)
            self.assertEqual([position[name][i] for name in ("x", "y", "z")], [2, i, -3])
            self.assertEqual([position[name][i] for name in ("vx", "vy", "vz")], [5, i, -6])
        self.assertAlmostEqual(position["heading"][0], 1.5707963, 6)  # the body looks east
        attitude = self.topic("vehicle_attitude")
        for name, value in zip(("q[0]", "q[1]", "q[2]", "q[3]"), (0.7071068, 0, 0, 0.7071068)):
            self.assertAlmostEqual(abs(attitude[name][0]), value, 6)
        rates = self.topic("vehicle_angular_velocity")
        for name, value in zip(("xyz[0]", "xyz[1]", "xyz[2]"), (0.1, -0.2, -0.3)):
            self.assertAlmostEqual(rates[name][0], value, 6)

    def test_setpoints(self):
        reference = self.topic("trajectory_setpoint")
        self.assertEqual(len(reference["timestamp"]), STEPS)
        self.assertEqual([reference[f"acceleration[{k}]"][0] for k in range(3)], [8, 7, -9])
        attitude = self.topic("vehicle_attitude_setpoint")
        self.assertEqual(len(attitude["timestamp"]), STEPS / 2)
        self.assertEqual(attitude["thrust_body[2]"][0], -0.5)
        self.assertEqual(self.topic("vehicle_rates_setpoint")["thrust_body[2]"][0], -0.5)

    def test_status_plan_and_texts(self):
        status = self.topic("swiftlet_status")
        self.assertEqual(status["tracking_error"][0], 0.25)
        self.assertGreaterEqual(len(status["timestamp"]), STEPS / 10)
        self.assertEqual(self.topic("swiftlet_plan")["duration"][0], 4)
        segments = self.topic("swiftlet_plan_segment")
        self.assertEqual(list(segments["duration"]), [1.5, 2.5])
        self.assertEqual([segments[f"high[{k}]"][1] for k in range(3)], [3, 1, 1])
        texts = self.log.logged_messages
        self.assertEqual(len(texts), 1)
        self.assertEqual(texts[0].timestamp, START + 500_000)
        self.assertEqual(texts[0].log_level_str(), "WARNING")
        self.assertRegex(texts[0].message, "^flying -> braking: ")

    def test_inputs_are_there(self):
        inputs = self.topic("swiftlet_input")
        self.assertEqual(len([name for name in inputs if name.startswith("bytes[")]), 120)

    def test_a_cut_log_is_read_up_to_there(self):
        whole = self.path.read_bytes()
        cut = FOLDER / "cut.ulg"
        for size in (len(whole) - 1, len(whole) // 2, len(whole) // 2 + 7):
            cut.write_bytes(whole[:size])
            log = pyulog.ULog(str(cut))
            self.assertFalse(log.file_corruption)
            self.assertGreater(len(log.get_dataset("vehicle_local_position").data["x"]), STEPS / 3)


if __name__ == "__main__":
    PROGRAM, FOLDER = sys.argv[1], pathlib.Path(sys.argv[2])
    unittest.main(argv=sys.argv[:1])
