"""airside-mqtt and a real mosquitto."""

import json
import os
import re
import signal
import socket
import subprocess
import time
import unittest
from pathlib import Path

import jinja2.sandbox
from desk import BIN, Desk, free_port, retained_at, within

# What Home Assistant asks of a document of MQTT discovery, and the values that it knows.
REQUIRED = {"name", "unique_id", "state_topic", "availability_topic", "value_template", "device", "origin"}
KNOWN = REQUIRED | {"device_class", "state_class", "unit_of_measurement", "suggested_display_precision", "options",
                    "payload_on", "payload_off", "json_attributes_topic", "json_attributes_template", "entity_category"}


def rendered(template, payload):
    """As Home Assistant does it: a sandbox in which the parsed payload is value_json."""
    return jinja2.sandbox.ImmutableSandboxedEnvironment().from_string(template).render(value_json=json.loads(payload))


def shown(value):
    return "None" if value is None else str(value)


def resident_kb(pid):
    return int(re.search(r"VmRSS:\s+(\d+)", Path(f"/proc/{pid}/status").read_text())[1])


class Discovery(Desk):
    """A real daemon's status, and what Home Assistant would make of it."""

    def daemon_status(self, objective="mean", room="301"):
        """Two hours of a simulated room under airsided, in self.folder/state."""
        port, ready = free_port(), self.folder / "ready"
        subprocess.run([BIN / "airside", "init", self.folder / "made", "--topology", self.TOPOLOGY, "--name", self.NAME,
                        "--objective", objective], check=True, stdout=subprocess.DEVNULL)
        text = (self.folder / "made" / "site.toml").read_text()
        for old, new in (("port = 502", f"port = {port}"), ('source = "system"', 'source = "plant"'),
                         ('dir = "state"', f'dir = "{self.folder}/state"')):
            self.assertIn(old, text)
            text = text.replace(old, new, 1)
        text += f'\n[mqtt]\nhost = "127.0.0.1"\nport = {self.broker.port}\n'
        (self.folder / "made" / "site.toml").write_text(text)
        (self.folder / "site.toml").write_text(text.replace('"points.csv"', '"made/points.csv"'))
        served = ["--site", self.folder / "made" / "site.toml", "--plant", "rc", "--room", room]
        server = subprocess.Popen([BIN / "airside", "serve", *served, "--port", str(port), "--ready", ready, "--days",
                                   "2"], stdout=subprocess.DEVNULL)
        self.addCleanup(self.kill, server)
        within(30, ready.exists, "airside serve answers")
        daemon = subprocess.Popen([BIN / "airsided", "--site", self.folder / "made" / "site.toml", "--no-sync"],
                                  stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL)
        self.addCleanup(self.kill, daemon)
        return daemon

    def test_what_is_shown_is_what_the_daemon_says(self):
        self.broker = self.start_broker()
        daemon = self.daemon_status()
        file = self.folder / "state" / "status.json"
        within(30, lambda: file.exists() and json.loads(file.read_text())["room_temp_degc"], "a row")
        listener = self.listen(self.broker)
        self.start()
        self.hears(listener, self.AVAILABILITY, "online")
        daemon.kill()  # dies at an instant of its own: its last status is that of its last row
        daemon.wait()
        self.hears(listener, self.STATUS, file.read_text().strip())
        truth = json.loads(file.read_text())
        self.assertFalse(truth["stopped"])
        found = self.documents(retained_at(self.broker))
        payload = listener.heard[self.STATUS]
        said = {name: rendered(document["value_template"], payload) for name, document in found.items()}
        self.assertEqual(len(truth["room_temp_degc"]), 3)
        for i, degc in enumerate(truth["room_temp_degc"]):
            self.assertEqual(said.pop(f"sensor/room_{i + 1}_temperature"), shown(degc))
        self.assertGreater(float(rendered(found["sensor/room_1_temperature"]["value_template"], payload)), 15)
        self.assertEqual(said, {
            "sensor/setpoint": shown(truth["setpoint_degc"]), "sensor/target": shown(truth["target_degc"]),
            "sensor/held": shown(truth["held_degc"]), "sensor/forecast": shown(truth["expected_held_degc"]),
            "sensor/mode": truth["state"], "sensor/reason": truth["reason"], "sensor/confidence": shown(truth["confidence"]),
            "binary_sensor/alarm": "ON" if truth["alarms"] else "OFF"})
        reason = found["sensor/reason"]
        self.assertEqual(json.loads(rendered(reason["json_attributes_template"], payload)),
                         {"why": truth["why"], "way_out": truth["way_out"]})
        # What the daemon's death is by its age: the file stays, and is old after 15 min.
        os.utime(file, (time.time() - 901,) * 2)
        self.hears(listener, self.AVAILABILITY, "offline")
        self.says("older than 15 min")

    def test_a_band_site_shows_its_zones_and_no_target(self):
        self.broker = self.start_broker()
        self.write_site(self.broker.port)  # the same AHU as long as its objective was mean
        self.write_status()
        before = self.start()
        self.says("published as online")
        self.assertIn("sensor/target", self.documents(retained_at(self.broker)))
        before.send_signal(signal.SIGTERM)
        before.wait(5)
        file = self.folder / "state" / "status.json"
        file.unlink()
        daemon = self.daemon_status("band", "modulating-mild")
        within(30, lambda: file.exists() and json.loads(file.read_text()).get("most_open_damper"), "a row")
        daemon.kill()
        daemon.wait()
        listener = self.listen(self.broker)
        self.start()
        payload = file.read_text().strip()
        self.hears(listener, self.STATUS, payload)
        self.hears(listener, self.AVAILABILITY, "online")
        truth = json.loads(payload)
        self.assertEqual(truth["objective"], "band")
        found = self.documents(retained_at(self.broker))
        rooms = {f"sensor/room_{i}_temperature" for i in (1, 2, 3)}
        self.assertEqual(set(found), rooms | {"sensor/setpoint", "sensor/warmest_zone", "sensor/most_open_damper",
                                              "sensor/mode", "sensor/reason", "binary_sensor/alarm"})
        warmest, damper = found["sensor/warmest_zone"], found["sensor/most_open_damper"]
        # A class of temperatures would have K converted to °C.
        self.assertEqual((warmest["unit_of_measurement"], warmest.get("device_class")), ("K", None))
        self.assertEqual(rendered(warmest["value_template"], payload), shown(truth["warmest_zone_above_setpoint_k"]))
        self.assertEqual(damper["unit_of_measurement"], "%")
        self.assertEqual(float(rendered(damper["value_template"], payload)), round(100 * truth["most_open_damper"]))
        unknown = json.dumps({**truth, "most_open_damper": None})
        self.assertEqual(rendered(damper["value_template"], unknown), "None")
        self.process.send_signal(signal.SIGTERM)
        self.process.wait(5)
        self.assertEqual(self.run_once("--forget").returncode, 0)
        self.assertEqual(retained_at(self.broker), {})

    def documents(self, retained):
        """COMPONENT/OBJECT -> document, each complete."""
        found, ids = {}, set()
        for topic, text in retained.items():
            if not topic.startswith("homeassistant/"):
                continue
            match = re.fullmatch(r"homeassistant/(sensor|binary_sensor)/([a-zA-Z0-9_-]+)/([a-zA-Z0-9_-]+)/config", topic)
            self.assertTrue(match, topic)
            document = json.loads(text)
            self.assertLessEqual(REQUIRED, document.keys(), topic)
            self.assertLessEqual(document.keys(), KNOWN, topic)
            self.assertEqual(document["state_topic"], self.STATUS)
            self.assertEqual(document["availability_topic"], self.AVAILABILITY)  # payloads: Home Assistant's defaults
            self.assertEqual(document["device"]["name"], self.NAME)
            self.assertTrue(document["device"]["identifiers"])
            self.assertTrue(document["origin"]["name"])
            if match[1] == "binary_sensor":
                self.assertEqual((document["device_class"], document["payload_on"], document["payload_off"]),
                                 ("problem", "ON", "OFF"))
                self.assertNotIn("state_class", document)
            elif document.get("device_class") == "enum":
                self.assertEqual(document["options"], ["learn", "run", "expert", "release"])
                self.assertNotIn("unit_of_measurement", document)
            elif document.get("device_class") == "temperature":
                self.assertEqual((document["unit_of_measurement"], document["state_class"]), ("°C", "measurement"))
            ids.add(document["unique_id"])
            found[f"{match[1]}/{match[3]}"] = document
        self.assertEqual(len(ids), len(found))
        self.assertEqual(len({document["device"]["identifiers"][0] for document in found.values()}), 1)
        return found

    def test_alarm_and_missing_rooms_are_shown(self):
        self.broker = self.start_broker()
        self.write_site(self.broker.port)
        text = self.write_status(alarms=[{"reason": "sensor drifts", "since": "2021-08-02T09:00:00"}])
        listener = self.listen(self.broker)
        self.start()
        self.hears(listener, self.STATUS, text)
        found = self.documents(retained_at(self.broker))
        self.assertEqual(rendered(found["binary_sensor/alarm"]["value_template"], text), "ON")
        self.assertEqual(json.loads(rendered(found["binary_sensor/alarm"]["json_attributes_template"], text)),
                         {"alarms": [{"reason": "sensor drifts", "since": "2021-08-02T09:00:00"}]})
        # "None" is how Home Assistant is shown that a sensor has no value.
        self.assertEqual(rendered(found["sensor/room_2_temperature"]["value_template"], text), "None")
        silent = json.dumps({**json.loads(text), "room_temp_degc": []})  # the AHU does not answer
        for room in (1, 2, 3):
            self.assertEqual(rendered(found[f"sensor/room_{room}_temperature"]["value_template"], silent), "None")

    def test_it_subscribes_to_nothing(self):
        self.broker = self.start_broker()
        self.write_site(self.broker.port)
        text = self.write_status()
        self.start()
        within(10, lambda: retained_at(self.broker).get(self.STATUS) == text, "published")
        log = self.broker.log.read_text()
        self.assertIn("Received PUBLISH from airside-room_301", log)
        self.assertNotIn("Received SUBSCRIBE from airside-room_301", log)


class Availability(Desk):
    def ready(self):
        self.broker = self.start_broker()
        self.write_site(self.broker.port)
        self.write_status()
        self.listener = self.listen(self.broker)
        process = self.start()
        self.hears(self.listener, self.AVAILABILITY, "online")
        return process

    def test_killed_it_leaves_its_last_will(self):
        process = self.ready()
        process.kill()
        self.hears(self.listener, self.AVAILABILITY, "offline")
        self.assertEqual(retained_at(self.broker)[self.AVAILABILITY], "offline")

    def test_told_to_stop_it_ends_in_order(self):
        process = self.ready()
        process.send_signal(signal.SIGTERM)
        self.assertEqual(process.wait(5), 0)
        self.hears(self.listener, self.AVAILABILITY, "offline")
        self.assertIn("Received DISCONNECT from airside-room_301", self.broker.log.read_text())
        self.assertTrue(self.said().endswith("airside-mqtt: stopped\n"), self.said())

    def test_an_old_status_is_offline_until_there_is_a_new_one(self):
        self.ready()
        self.write_status(age_s=901)
        self.hears(self.listener, self.AVAILABILITY, "offline")
        text = self.write_status(setpoint_degc=23.0)
        self.hears(self.listener, self.STATUS, text)
        self.hears(self.listener, self.AVAILABILITY, "online")

    def test_a_daemon_that_stopped_is_offline(self):
        self.ready()
        self.write_status(stopped=True)
        self.hears(self.listener, self.AVAILABILITY, "offline")

    def test_a_status_that_is_none_is_offline(self):
        self.ready()
        file = self.folder / "state" / "status.json"
        file.write_text("{\"state\":")
        self.hears(self.listener, self.AVAILABILITY, "offline")
        self.says("no JSON object")
        before = self.listener.heard[self.STATUS]
        json.loads(before)  # what was not whole is not published
        self.write_status()
        self.hears(self.listener, self.AVAILABILITY, "online")
        file.unlink()
        self.hears(self.listener, self.AVAILABILITY, "offline")
        self.says("No such file")


class BrokerThatDies(Desk):
    def test_it_is_informed_again_and_of_the_newest_alone(self):
        broker = self.start_broker()
        self.write_site(broker.port)
        self.write_status()
        process = self.start()
        within(10, lambda: retained_at(broker).get(self.AVAILABILITY) == "online", "online")
        everything = retained_at(broker)
        broker.stop(signal.SIGKILL)
        self.says("Connection refused")
        before_kb = resident_kb(process.pid)
        until, written = time.monotonic() + 2, 0
        while time.monotonic() < until:  # ten hours of rows and more
            text = self.write_status(cycles=written)
            written += 1
            time.sleep(0.01)
        self.assertGreater(written, 100)
        self.assertLess(resident_kb(process.pid) - before_kb, 256)
        broker.start()
        listener = self.listen(broker)
        self.hears(listener, self.STATUS, text, seconds=15)
        self.hears(listener, self.AVAILABILITY, "online")
        self.assertEqual([t for t, _ in listener.messages].count(self.STATUS), 1)
        again = retained_at(broker)
        self.assertEqual(again.pop(self.STATUS), text)
        everything.pop(self.STATUS)
        self.assertEqual(again, everything)
        self.assertEqual(self.said().count("Connection refused"), 1)  # said once, however often it was tried

    def test_without_a_broker_it_waits_and_ends_when_asked(self):
        self.write_site(free_port())
        self.write_status()
        process = self.start()
        self.says("Connection refused")
        process.send_signal(signal.SIGTERM)
        self.assertEqual(process.wait(5), 0)


class BrokerThatHangs(Desk):
    def test_one_that_takes_no_connection_keeps_nobody_from_stopping(self):
        with socket.socket() as full:
            full.bind(("127.0.0.1", 0))
            full.listen(0)
            waiting = [socket.socket() for _ in range(4)]  # the queue is full: a further connect() is not answered
            for one in waiting:
                self.addCleanup(one.close)
                one.setblocking(False)
                one.connect_ex(full.getsockname())
            self.write_site(full.getsockname()[1])
            self.write_status()
            process = self.start()
            time.sleep(1)
            self.assertEqual(self.said(), "")  # it waits
            process.send_signal(signal.SIGTERM)
            self.assertEqual(process.wait(3), 0)

    def test_it_is_left_and_found_again(self):
        broker = self.start_broker()
        self.write_site(broker.port)
        self.write_status()
        process = self.start()
        within(10, lambda: retained_at(broker).get(self.AVAILABILITY) == "online", "online")
        broker.process.send_signal(signal.SIGSTOP)
        self.write_status(setpoint_degc=21.0)
        time.sleep(1)
        text = self.write_status(setpoint_degc=24.0)
        self.says("found no answer; expected an MQTT broker that answers within 15 s", seconds=30)
        broker.process.send_signal(signal.SIGCONT)
        listener = self.listen(broker)
        self.hears(listener, self.STATUS, text, seconds=30)
        self.hears(listener, self.AVAILABILITY, "online")
        self.assertIsNone(process.poll())


class Refusals(Desk):
    def setUp(self):
        super().setUp()
        passwords, self.password = self.folder / "passwords", self.folder / "password"
        subprocess.run(["mosquitto_passwd", "-b", "-c", passwords, "ahu", "right"], check=True, capture_output=True)
        self.broker = self.start_broker([f"password_file {passwords}", "allow_anonymous false"])
        self.write_status()

    def write_password(self, text, mode=0o640):
        self.password.write_text(text)
        self.password.chmod(mode)
        self.write_site(self.broker.port, 'username = "ahu"\npassword_file = "password"')

    def refused(self, *parts):
        done = self.run_once("--check")
        self.assertEqual(done.returncode, 1, done.stdout)
        for part in parts:
            self.assertIn(part, done.stderr)
        self.assertNotIn("wrong", done.stderr)  # passwords are not repeated

    def test_a_password_that_is_right(self):
        self.write_password("right\n")
        done = self.run_once("--check")
        self.assertEqual((done.returncode, done.stderr), (0, ""))
        self.assertIn("takes airside-mqtt of \"Room 301\"", done.stdout)

    def test_a_password_that_is_not(self):
        self.write_password("wrong\n")
        self.refused(f"site.toml: [mqtt]: broker 127.0.0.1 port {self.broker.port}: found \"not authorised\"",
                     "expected a broker that knows \"ahu\" by this password", "correct username or password_file")

    def test_no_password(self):
        self.write_site(self.broker.port)
        self.refused("not authorised", "expected a broker that takes clients without a name",
                     "add username and password_file")

    def test_a_password_that_everybody_may_read(self):
        self.write_password("wrong\n", 0o644)
        self.refused("password: found permissions 644", "only its owner and group", "chmod 640")

    def test_no_password_in_the_file(self):
        self.write_password("\nwrong\n")
        self.refused("password: found a first line of 0 bytes", "write it into the first line")

    def test_corrected_it_is_taken_without_a_restart(self):
        self.write_password("wrong\n")
        process = self.start()
        self.says("not authorised")
        self.write_password("right\n")
        within(15, lambda: retained_at(self.broker, username="ahu", password="right").get(self.AVAILABILITY) == "online",
               "online")
        self.assertIsNone(process.poll())


class Certificates(Desk):
    """TLS with an authority of our own."""

    def setUp(self):
        super().setUp()
        for name in ("ca", "other"):
            self.openssl("req", "-x509", "-newkey", "rsa:2048", "-nodes", "-days", "2", "-subj", f"/CN={name}",
                         "-keyout", f"{name}.key", "-out", f"{name}.pem")
        self.openssl("req", "-newkey", "rsa:2048", "-nodes", "-subj", "/CN=localhost", "-keyout", "broker.key", "-out",
                     "broker.csr")
        (self.folder / "names").write_text("subjectAltName = DNS:localhost\n")
        self.openssl("x509", "-req", "-in", "broker.csr", "-CA", "ca.pem", "-CAkey", "ca.key", "-CAcreateserial",
                     "-days", "2", "-extfile", "names", "-out", "broker.pem")
        self.broker = self.start_broker([f"cafile {self.folder}/ca.pem", f"certfile {self.folder}/broker.pem",
                                         f"keyfile {self.folder}/broker.key", "allow_anonymous true"])
        self.write_status()

    def openssl(self, *arguments):
        subprocess.run(["openssl", *arguments], cwd=self.folder, check=True, capture_output=True)

    def test_what_is_encrypted_for_whom(self):
        self.write_site(self.broker.port, 'tls_ca = "ca.pem"', host="localhost")
        done = self.run_once("--check")
        self.assertEqual((done.returncode, done.stderr), (0, ""))
        self.start()
        self.says("published as online")
        self.assertIn("Received PUBLISH from airside-room_301", self.broker.log.read_text())
        for host, more, parts in (
                ("localhost", 'tls_ca = "other.pem"', ["no TLS (certificate verify failed)", "signed by tls_ca ="]),
                ("127.0.0.1", 'tls_ca = "ca.pem"', ["no TLS", "a certificate for this very host name"]),
                ("localhost", "", ["ended before an answer", "or give tls_ca"]),
                ("localhost", 'tls_ca = "names"', ["names: found no certificate", "certificates in PEM"]),
                ("localhost", 'tls_ca = "none.pem"', ["none.pem: found no file that can be read"])):
            with self.subTest(host=host, more=more):
                self.write_site(self.broker.port, more, host)
                done = self.run_once("--check")
                self.assertEqual(done.returncode, 1)
                for part in parts:
                    self.assertIn(part, done.stderr)


class CommandLine(Desk):
    def test_the_list_is_what_is_published(self):
        broker = self.start_broker()
        self.write_site(broker.port, 'topic_prefix = "haus/süd"\ndiscovery_prefix = "ha"')
        self.write_status()
        listed = dict(line.partition("\t")[::2] for line in self.run_once("--list").stdout.splitlines())
        self.start()
        self.says("published as online")
        retained = retained_at(broker)
        self.assertEqual(set(listed), set(retained))
        self.assertEqual({t: p for t, p in listed.items() if p}, {t: p for t, p in retained.items() if t.startswith("ha/")})
        self.assertIn("haus/süd/status", retained)

    def test_no_discovery(self):
        broker = self.start_broker()
        self.write_site(broker.port, 'discovery_prefix = ""')
        self.write_status()
        self.start()
        self.says("published as online")
        self.assertEqual(set(retained_at(broker)), {self.STATUS, self.AVAILABILITY})

    def test_what_is_withdrawn_is_gone(self):
        broker = self.start_broker()
        self.write_site(broker.port)
        self.write_status()
        process = self.start()
        self.says("published as online")
        process.send_signal(signal.SIGTERM)
        process.wait(5)
        self.assertEqual(len(retained_at(broker)), 13)
        done = self.run_once("--forget")
        self.assertEqual(done.returncode, 0, done.stderr)
        self.assertEqual(retained_at(broker), {})

    def test_a_site_without_a_broker_is_refused(self):
        (self.folder / "site.toml").write_text('[site]\nname = "a"\ntopology = "3vav-0fcu-1power"\n')
        done = self.run_once()
        self.assertEqual(done.returncode, 1)
        self.assertIn("site.toml: [mqtt]: found no such table; expected the broker to publish to; add [mqtt] with host",
                      done.stderr)

    def test_a_broker_that_is_not_there(self):
        for host, found in (("127.0.0.1", "Connection refused"), ("nowhere.invalid", "no address of that name")):
            self.write_site(free_port(), host=host)
            for what in ("--check", "--forget"):
                done = self.run_once(what)
                self.assertEqual(done.returncode, 1)
                self.assertIn(found, done.stderr)

    def test_two_jobs_at_once_are_refused(self):
        self.write_site(free_port())
        self.assertEqual(self.run_once("--check", "--forget").returncode, 2)


if __name__ == "__main__":
    unittest.main()
