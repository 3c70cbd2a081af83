"""Hostile input and events: what an attacker, a broken driver or an unlucky user may do."""
