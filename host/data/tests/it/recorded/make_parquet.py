"""Makes polars.parquet and polars_zstd.parquet: pip install polars; python make_parquet.py."""

import polars

ROWS = 50
table = polars.DataFrame(
    {
        "t_us": [7_000_000_000 + 4000 * k for k in range(ROWS)],
        "Fx": [0.25 * k for k in range(ROWS)],
        "Fy": [-20.0] * ROWS,
        # Not measured in the first rows.
        "Fz": [None if k < 5 else 0.5 for k in range(ROWS)],
        "Tx": [-0.125] * ROWS,
        "Ty": [float(k) for k in range(ROWS)],
        "Tz": [0.0] * ROWS,
    },
    schema_overrides={"t_us": polars.Int64, "Fy": polars.Float32},
)
table.write_parquet("polars.parquet", compression="snappy")
table.write_parquet("polars_zstd.parquet", compression="zstd")
