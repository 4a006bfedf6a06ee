"""DESIGN's table of targets, as far as no other section measures them."""

NAME = "targets"
TITLE = "The project's own targets"
SCANS, OCTOMAP_SECONDS = 20, 12


def measure(job):
    if job.short:  # OctoMap takes a minute for the least it measures.
        return {}
    return job.lines("bench_import", "--scans", SCANS, "--octomap-seconds", OCTOMAP_SECONDS,
                     *job.real_scans())


def show(page, values, all_values):
    if not values:
        page.text("Not measured in the short form: `scripts/bench import` does.")
        return
    page.text("OctoMap = 1 in the same run, on the same scans; one thread, processor time, but for two "
              "workers. Targets in brackets: must.")
    judged = not values["ratios_void"]
    if values["ratios_void"]:
        page.text("The machine was too slow while OctoMap ran: its ratios are void and not judged.")

    def ratio(name, target, at_least=True):
        return page.judged(values[name], f"{values[name]:.3g}", target, at_least, judged)

    rows = [["carving at 10 cm to 100 m, warm (60)", ratio("carve100_warm_vs_octomap", 60)],
            ["surface only (8)", ratio("surface_vs_octomap", 8)],
            ["free space at 80 cm (5)", ratio("free80_vs_octomap", 5)],
            ["two workers over one (1.5)",
             page.judged(values["threads2_speedup"], f"{values['threads2_speedup']:.3g}", 1.5)],
            ["resident memory (0.2)", ratio("memory_vs_octomap", 0.2, at_least=False)]]
    codecs = all_values.get("codecs")
    if codecs:
        share = codecs["lossless_vs_ot_zstd19"]
        rows.append(["lossless bytes, OctoMap's .ot with zstd 19 = 1 (0.60)",
                     page.judged(share, f"{share:.3g}", 0.60, at_least=False)])
    page.table(["what", "measured"], rows)
    page.text("Rays a second, one thread: carving "
              f"{values['carve100_warm_rays_per_s'] / 1e6:.2f} M, surface only "
              f"{values['surface_rays_per_s'] / 1e6:.1f} M, free space at 80 cm "
              f"{values['free80_rays_per_s'] / 1e6:.2f} M; two runs of the same lay "
              f"{100 * values['carve100_noise']:.0f} % apart. Through the bus, and of pictures: see "
              "the drive and table 1.")
