# The house's rules as data: which folder of libs/ may include which, and who may see the transport.
PURE = {"core", "config", "robot", "symbols", "optim", "scene", "motion", "physics", "rules", "study"}

# folder → folders whose headers it may include, beside its own.
ALLOWED = {
    "core": set(),
    "config": {"core"},
    "robot": {"core", "config"},
    "symbols": {"core", "config"},
    "optim": {"core", "config"},
    "scene": {"core", "config", "robot", "symbols"},
    "motion": {"core", "config", "robot", "symbols", "scene"},
    "physics": {"core", "config", "robot", "symbols", "scene"},
    "rules": {"core", "config", "symbols"},
    "study": PURE,
    "bus": {"core", "config"},
    "service": {"core", "config", "bus"},
    "wire": PURE,
    # Not libraries, but held to the same table:
    "services": PURE | {"bus", "service", "wire"},
    "tools": PURE | {"bus", "service", "wire"},
}

# Include prefix → the folders that may use it.
TRANSPORT = ("fastdds/", "fastrtps/", "fastcdr/")
MAY_SEE_TRANSPORT = {"bus"}
# Generated types (idl/*.idl → X.h, XPubSubTypes.h).
MAY_SEE_GENERATED = {"bus", "service", "wire", "services", "tools"}

MAX_LINES = 500
