"""Hands: their description, kinematics, tendon drive and grasp motions."""
