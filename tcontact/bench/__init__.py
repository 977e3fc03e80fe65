"""The benchmark behind `tcontact bench`: every configuration in a process of its own, every speed with its errors."""
