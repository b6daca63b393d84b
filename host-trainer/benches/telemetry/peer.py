"""What a user would write: paho-mqtt into sqlite3, each message committed before its acknowledgement.

Arguments: file, port, number of messages to wait for. Prints the seconds from the connection to the last message.
"""
import sqlite3
import struct
import sys
import time
import zlib

import paho.mqtt.client as mqtt

path, port, count = sys.argv[1], int(sys.argv[2]), int(sys.argv[3])
database = sqlite3.connect(path, isolation_level=None)
database.execute("PRAGMA journal_mode = WAL")
database.execute("PRAGMA synchronous = FULL")
database.execute("CREATE TABLE IF NOT EXISTS messages (machine TEXT, session INTEGER, sequence INTEGER, kind INTEGER, "
                 "status INTEGER, model INTEGER, unix_ms INTEGER, recording INTEGER, time_s REAL, block INTEGER, level REAL, "
                 "deviation REAL, ewma REAL, ewma_limit REAL, PRIMARY KEY (machine, session, sequence))")
LAYOUT = struct.Struct("<4sBBBB32sQIIQIdIffff")
state = {"left": count, "start": time.perf_counter()}


def on_connect(client, *_):
    state["start"] = time.perf_counter()
    client.subscribe("plant/#", qos=1)


def on_message(client, _, message):
    data = message.payload
    if len(data) == 124 and zlib.crc32(data[:120]) == struct.unpack("<I", data[120:])[0]:
        (_, _, kind, status, _, name, session, sequence, model, unix_ms, recording, time_s, block, level, deviation, ewma,
         limit) = LAYOUT.unpack_from(data)
        row = (name.rstrip(b"\0").decode(), session, sequence, kind, status, model, unix_ms, recording, time_s, block, level,
               deviation, ewma, limit)
        database.execute(f"INSERT OR IGNORE INTO messages VALUES ({','.join('?' * len(row))})", row)
    state["left"] -= 1
    if state["left"] == 0:
        client.disconnect()


def on_subscribe(client, *_):
    if count == 0:
        client.disconnect()


client = mqtt.Client(mqtt.CallbackAPIVersion.VERSION2, client_id="peer", clean_session=False)
client.on_connect, client.on_message, client.on_subscribe = on_connect, on_message, on_subscribe
client.connect("127.0.0.1", port)
client.loop_forever()
print(time.perf_counter() - state["start"])
