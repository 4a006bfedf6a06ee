"""Beyond the paper: one model with drives all over the Earth."""

import json
import shutil
import subprocess
import time

from page import number

from service_set import ServiceSet, default_bin_dir

NAME = "planet"
TITLE = "Beyond the paper: a planet in one model"
PLACES = {"Munich": "48.1489,11.5680,560", "Tokyo": "35.6812,139.7671,40",
          "Nairobi": "-1.2864,36.8172,1660", "Sao Paulo": "-23.5505,-46.6333,760",
          "Anchorage": "61.2181,-149.9003,30", "across the date line": "-16.8000,180.0000,20",
          "at the north pole": "89.9995,0.0000,10"}
MOST_SCANS = 200


def publish(services, city, scans):
    return json.loads(services.run("publish", "--simulate", scans, "--source", city, "--place",
                                   PLACES[city], "--json", quiet=True))


def measure(job):
    scans = max(4, min(job.options.scans // 5, MOST_SCANS))
    model = job.work("model-planet")
    shutil.rmtree(model, ignore_errors=True)
    before, after = job.work("planet-before.txt"), job.work("planet-after.txt")
    with ServiceSet(model) as services:
        published = {city: publish(services, city, scans) for city in PLACES}
        stat = json.loads(services.run("stat", "--hashes", before, "--json"))
        for city, place in PLACES.items():
            services.run("render", "--at", place_above(place), "--map", 700, "--out",
                         job.pictures() / f"planet_{slug(city)}.png", quiet=True)
    began = time.monotonic()
    with ServiceSet(model) as services:
        restart = time.monotonic() - began
        services.run("stat", "--hashes", after, "--json")
    verified = subprocess.run([default_bin_dir() / "voxatlas", "store", "verify", "--data-dir", model],
                              check=False, capture_output=True, text=True, stdin=subprocess.DEVNULL)
    shutil.rmtree(model)
    differing = set(before.read_text().splitlines()) ^ set(after.read_text().splitlines())
    return {"published": published, "scans": scans, "stat": stat, "restart": restart, "differing": len(differing),
            "verified": verified.returncode == 0, "said": verified.stdout.strip() if verified.returncode == 0 else verified.stderr.strip()}


def place_above(place):
    latitude, longitude, height = place.split(",")
    return f"{latitude},{longitude},{float(height) + 100:g}"


def slug(city):
    return city.lower().replace(" ", "_")


def show(page, values, _all):
    page.text("The same city and drive in seven places, all in one model through the bus; then all "
              "services were stopped and started again, every tile's hash compared, and every byte "
              "on disk verified.")
    page.table(["place", "latitude, longitude, height", "scans durable", "points", "points/s"],
               [[city, PLACES[city].replace(",", ", "), number(p["durable"]), number(p["rays"]),
                 number(p["rays"] / p["seconds"])] for city, p in values["published"].items()])
    stat = values["stat"]
    same = "the same" if values["differing"] == 0 else f"**{values['differing']} lines differ**"
    verified = "verified" if values["verified"] else "**not verified**"
    page.text(f"{number(stat['tiles'])} tiles, {number(stat['occupied_voxels'])} voxels occupied, "
              f"{number(stat['encoded_bytes'])} bytes encoded. Ready again {values['restart']:.1f} s after "
              f"the start, tiles {same}; {verified}: `{values['said']}`")
    for city in values["published"]:
        page.picture(f"planet_{slug(city)}.png", f"{city}: from above, 700 m wide, north up.")
