# mjbiped in a container:
#   docker build --tag mjbiped .
#   docker run --rm --volume "$PWD/out:/out" mjbiped walk mixed --initial rest --out /out/walk.npz --video /out/walk.mp4
# The README's two commands in it:
#   docker run --rm --entrypoint make mjbiped walk test
FROM python:3.11-slim-bookworm

# make; a compiler for packages without wheels; OpenGL without a screen
RUN apt-get update && apt-get install --yes --no-install-recommends make gcc libc6-dev libegl1 libgl1-mesa-dri && rm -rf /var/lib/apt/lists/*

# machine code that long walks compile
ENV NUMBA_CACHE_DIR=/var/cache/mjbiped MUJOCO_GL=egl

WORKDIR /mjbiped
COPY . .
RUN make setup
ENTRYPOINT ["/mjbiped/.venv/bin/mjbiped"]
CMD ["--help"]
